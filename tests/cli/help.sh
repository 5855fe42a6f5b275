#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Every command explains itself, and its manual page is free of warnings.
. "$(dirname "$0")/cli.bash"

expect 0 "$TTFBOX" --help
said out "synth quilt"
expect 0 "$TTFBOX" --version
said out "ttfbox "
expect 2 "$TTFBOX"
said err "Usage: ttfbox"
expect 2 "$TTFBOX" captur
said err "there is no command 'captur'"
expect 2 "$TTFBOX" plan
said err "needs a second word"
expect 0 "$TTFBOX" plan --help
said out "plan check"
expect 2 "$TTFBOX" plan chek
said err "there is no command 'plan chek'"
expect 2 "$TTFBOX" help nonsense
expect 0 "$TTFBOX" help synth
said out "synth quilt"
said out "Usage: ttfbox synth COMMAND"

commands=$("$TTFBOX" --help | sed -n 's/^  \([a-z]\+\( [a-z]\+\)\?\)  .*/\1/p' | sort -u)
[ "$(wc -l <<<"$commands")" -ge 13 ] || fail "not all commands are listed: $commands"

while read -r command; do
    read -ra words <<<"$command"
    expect 0 "$TTFBOX" "${words[@]}" --help
    said out "Usage: ttfbox $command"
    said out "Examples:"
    [ -s "$WORK/err" ] && fail "$command --help says something on standard error"
    cp out help
    expect 2 "$TTFBOX" "${words[@]}" --no-such-option
    expect 0 "$TTFBOX" help --man "${words[@]}"
    cp out page
    sed 's/\\-/-/g' page >plain
    # The page names every option that --help names: they are of one source.
    grep -o -- '--[a-z-]\+' help | sort -u | while read -r option; do
        [ "$option" = --usage ] && continue
        grep -qF -- "$option" plain || fail "$command: the page lacks $option"
    done || exit 1
    if command -v groff >/dev/null; then
        groff -ww -z -man -Tutf8 page 2>warnings || fail "$command: groff"
        [ -s warnings ] && { cat warnings >&2; fail "$command: the page has warnings"; }
        groff -man -Tascii -P-c page >text 2>/dev/null
        grep -q "damaged data" text || fail "$command: the page is empty"
    fi
done <<<"$commands"
# Each has its page among those that are installed.
while read -r command; do
    grep -A 6 '^set(TTFBOX_PAGES' "$SOURCE/firmware/cli/CMakeLists.txt" | sed '/)/q' | tr -s ' ()' '\n' |
        grep -qx -- "${command// /-}" || fail "no page of '$command' is installed"
done <<<"$commands"
expect 0 "$TTFBOX" help --man
command -v groff >/dev/null || echo "groff is not installed: the pages' troff was not checked"
echo "help: all commands explain themselves"
