/* -1, 0 or 1 with the sign of x. */
static inline double sgn(double x) { return x > 0.0 ? 1.0 : x < 0.0 ? -1.0 : x*0.0; }
static inline double step(double x) { return 0.5 + 0.5*sgn(x); }
static inline double rest(double x) { return x == 0.0 ? 1.0 : x != x ? x : 0.0; }
static inline double pos(double x) { return x <= 0.0 ? 0.0 : x; }
static inline double smaller(double a, double b) { return a < b || a != a ? a : b; }
static inline double larger(double a, double b) { return a > b || a != a ? a : b; }
static inline double modulo(double a, double b) { return a - b*floor(a/b); }
static inline double gate(double a, double b) { return b > 0.0 ? a : 0.0; }
static inline double masked(double a, double b) { return a == 0.0 || b == 0.0 ? 0.0 : a*b; }
/* x outside of +-g, less g; 0 inside. */
static inline double dead(double x, double g)
{
    double beyond = fabs(x) - g;
    return beyond > 0.0 ? sgn(x)*beyond : beyond != beyond ? beyond : 0.0;
}
