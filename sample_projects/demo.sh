#!/bin/sh
# The main job on a real space photograph: Apollo 15 mapping camera, frame 0585, from lunar orbit.
# Run by `make demo`; needs `orient` in $BIN and writes into $DEMO.
set -eu
BIN=${BIN:-.venv/bin}
DEMO=${DEMO:-demo}
PROJECT=$DEMO/as15-0585.sqlite
SAMPLES=$(dirname "$0")

say() { printf '\n$ %s\n' "$*"; }
step() { say "orient $*"; "$BIN/orient" "$@"; }

mkdir -p "$DEMO"
rm -f "$PROJECT"

step new "$PROJECT" --from "$SAMPLES/apollo15-metric-0585" -m "the published bundle's points as control"
step run "$PROJECT"
step show "$PROJECT" resection
step sql "$PROJECT" "SELECT iteration, unknown, approximation, correction, adjusted, unit
    FROM v_iteration WHERE is_current AND point = '' AND unknown IN ('Z_S', 'omega')
    ORDER BY unknown, iteration"
step sql "$PROJECT" "SELECT point, round(1000 * vx_mm, 2) AS vx_um, round(1000 * vy_mm, 2) AS vy_um
    FROM v_residual WHERE is_current ORDER BY vx_mm * vx_mm + vy_mm * vy_mm DESC LIMIT 5"
step check "$PROJECT"
printf '\nThe whole proof is in one file: %s\n' "$PROJECT"
