# Sourced. catalogue README: the rows of the fault catalogue, one a line: number, tab, suites, tab, sabotage.
catalogue() {
  awk -F'|' '/^\| [0-9]+ \|/ {
    gsub(/ /, "", $2); suites = $4; patch = $5
    gsub(/`/, "", suites); gsub(/^ +| +$/, "", suites); gsub(/[` ]/, "", patch)
    print $2 "\t" suites "\t" patch }' "$1"
}
