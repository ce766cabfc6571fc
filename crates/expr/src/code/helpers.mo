  function sgn "-1, 0 or 1 with the sign of x"
    input Real x;
    output Real y;
  algorithm
    y := if x > 0 then 1.0 elseif x < 0 then -1.0 else 0.0;
  end sgn;

  function step
    input Real x;
    output Real y;
  algorithm
    y := if x > 0 then 1.0 elseif x < 0 then 0.0 else 0.5;
  end step;

  function rest
    input Real x;
    output Real y;
  algorithm
    y := if x > 0 or x < 0 then 0.0 else 1.0;
  end rest;

  function pos
    input Real x;
    output Real y;
  algorithm
    y := if x > 0 then x else 0.0;
  end pos;

  function dead "x outside of +-g, less g; 0 inside"
    input Real x;
    input Real g;
    output Real y;
  algorithm
    y := if abs(x) > g then sgn(x)*(abs(x) - g) else 0.0;
  end dead;

  function smaller
    input Real a;
    input Real b;
    output Real y;
  algorithm
    y := if a < b then a else b;
  end smaller;

  function larger
    input Real a;
    input Real b;
    output Real y;
  algorithm
    y := if a > b then a else b;
  end larger;

  function gate "a where b > 0, else 0"
    input Real a;
    input Real b;
    output Real y;
  algorithm
    y := if b > 0 then a else 0.0;
  end gate;

  function masked "Product in which zero wins"
    input Real a;
    input Real b;
    output Real y;
  algorithm
    y := if a == 0 or b == 0 then 0.0 else a*b;
  end masked;
