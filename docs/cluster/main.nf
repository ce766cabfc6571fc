// A sweep as sixteen tasks of Nextflow and one that merges them.
//
//   nextflow run docs/cluster/main.nf --spec specs/case1a.ron --seeds 1000 --parts 16 -resume

params.spec = 'specs/case1a.ron'
params.seeds = 1000
params.parts = 16

process part {
    cpus 4
    errorStrategy 'retry'
    maxRetries 3

    input:
    tuple path(spec), val(number)

    output:
    path "part/sweep-${number}-of-${params.parts}.jsonl"

    script:
    """
    phisindy sweep ${spec} --seeds ${params.seeds} --shard ${number}/${params.parts} \
        --jobs ${task.cpus} --quiet --out part > /dev/null
    """
}

process table {
    publishDir 'sweep', mode: 'copy', saveAs: { 'sweep.json' }

    input:
    path journals

    output:
    path 'table/sweep.json'

    script:
    """
    phisindy sweep --merge . --out table > /dev/null
    """
}

workflow {
    spec = Channel.fromPath(params.spec)
    part(spec.combine(Channel.of(1..params.parts))) | collect | table
}
