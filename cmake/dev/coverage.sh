#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Lines and branches of dataset/ and capture/ that the tests reach; called by ./dev coverage from the
# root, with the build made. Arguments go to coverage.py.
set -uo pipefail
jobs=$(nproc)
find build-coverage -name '*.gcda' -delete
# The syntheses and the devices are not counted, so their own tests are left out. appliance_300 holds the whole box to the
# second, beside 50 readers, on a machine that does nothing else: here it would judge what counting costs, and it reaches
# nothing of the two rooms that the daemon's other tests do not.
ctest --preset coverage -j "$jobs" -L 'unit|sim|cli' \
    -E '^test_(synth|quilt|rank|search|agreement|boundary|timed|time_jitter|factors|map_file|scenes|hal_|conformance|guardian|sim)|^appliance|quilt' \
    >build-coverage/tests.log 2>&1
status=$?
if [ "$status" -ne 0 ]; then
    grep -E '\*\*\*(Failed|Timeout|Exception)' build-coverage/tests.log
    # Some hold a box to its seconds, which two tests at a time and what else the machine does can take: once more, each alone.
    echo "once more, alone:"
    # By name: --rerun-failed goes by numbers, which -L and -E above have changed.
    failed=$(sed -n 's/^[0-9]*://p' build-coverage/Testing/Temporary/LastTestsFailed.log | paste -sd '|')
    ctest --preset coverage -j 1 --no-tests=error -R "^($failed)\$" >build-coverage/tests-again.log 2>&1
    status=$?
    grep -E 'Passed|\*\*\*(Failed|Timeout|Exception)' build-coverage/tests-again.log
fi
gcovr --root . --object-directory build-coverage --filter dataset/ --filter capture/ -j "$jobs" \
    --exclude-unreachable-branches --json build-coverage/coverage.json \
    --html-details build-coverage/coverage.html >build-coverage/gcovr.log 2>&1 || {
    cat build-coverage/gcovr.log
    exit 1
}
python3 cmake/dev/coverage.py build-coverage/coverage.json "$@" || exit 1
echo "each line: build-coverage/coverage.html"
exit "$status"
