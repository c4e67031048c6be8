#!/bin/sh
# The first process of the container, with whose end all others are killed: it outlives the program until the
# guard has sent its zeros and ended.
exec 3<&0
barrelman "$@" <&3 3<&- &
program=$!
trap 'kill -TERM "$program" 2>/dev/null' TERM HUP
# A terminal sends Ctrl-C to the program, too.
trap : INT

# A signal interrupts wait before the program has ended.
while wait "$program"; status=$?; kill -0 "$program" 2>/dev/null; do :; done
# --ns: with the machine's process numbers (--pid=host) only the guards of this container.
while pgrep --ns $$ --nslist mnt --exact barrelman-guard >/dev/null; do sleep 0.1; done
exit "$status"
