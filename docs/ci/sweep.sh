#!/bin/sh
# One sweep in any CI system: report, JUnit, and a comparison with a baseline.
# usage: docs/ci/sweep.sh SWEEP OUT [BASELINE]
#   SWEEP     a sweep file or a scene
#   OUT       folder for results; keep OUT/report.html, OUT/summary.md, OUT/junit.xml and OUT/results.csv as artifacts
#   BASELINE  a results.csv of an accepted version; to accept this one: cp OUT/results.csv BASELINE
# Exit code: 0 all well, 1 an expectation was missed or something is worse than the baseline, 2 something could not run.
# The program is $WHEREIN, `wherein` unless set. Called again after an interruption, it goes on where it stopped.
set -eu
wherein=${WHEREIN:-wherein}
sweep=$1 out=$2 baseline=${3:-}

code=0
"$wherein" sweep "$sweep" --out "$out" --frames failures --junit "$out/junit.xml" || code=$?
if [ "$code" -gt 1 ]; then
	exit "$code"
fi
if [ -n "$baseline" ]; then
	worse=0
	"$wherein" compare "$baseline" "$out" || worse=$?
	if [ "$worse" -gt "$code" ]; then
		code=$worse
	fi
fi
exit "$code"
