#!/bin/bash
# How long programs take by the planner of GRBL 1.1: builds grbl_time.c with GRBL's sources, once, and runs it.
# Usage: grbl_time.sh SOURCES.tar.xz PROGRAM FEED_MM_MIN ACCELERATION_MM_S2 JUNCTION_DEVIATION_MM    prints seconds.
# Exit 1: a block was refused; 2: it could not be built (gcc, make?).
set -u
here=$(cd "$(dirname "$0")" && pwd); at=${XDG_CACHE_HOME:-$HOME/.cache}/evencut-grbl-time; sim=$at/grbl/grbl-sim
if [ ! -x "$sim/grbl_time" ] || [ "$here/grbl_time.c" -nt "$sim/grbl_time" ]; then
  mkdir -p "$at" && tar -C "$at" -xJf "$1" && make -s -C "$sim" CC="gcc -fcommon -w" gvalidate >/dev/null 2>&1
  cp "$here/grbl_time.c" "$sim/" && (cd "$sim" && gcc -fcommon -w -O2 -DF_CPU=16000000 -include config.h -I. \
    -DPLAT_LINUX -o grbl_time.new grbl_time.c overridden_report.o ../protocol.o ../planner.o ../settings.o ../print.o \
    ../nuts_bolts.o ../gcode.o ../spindle_control.o ../motion_control.o ../limits.o ../coolant_control.o ../probe.o \
    ../system.o ../jog.o avr/interrupt.o avr/pgmspace.o avr/io.o avr/eeprom.o grbl_eeprom_extensions.o \
    system_declares.o -lm -lrt -pthread && mv grbl_time.new grbl_time) >&2
  [ -x "$sim/grbl_time" ] || { echo "grbl_time: could not be built" >&2; exit 2; }
fi
# GRBL leaves its settings where it runs.
cd "$sim" && exec ./grbl_time "$3" "$4" "$5" < "$2"
