#!/bin/sh
# Compiles the library for this machine; CC and CFLAGS may say how.
set -e
cd "$(dirname "$0")"
machine="$(uname -m)"
[ "$machine" != x86_64 ] || cpu=-march=x86-64-v2
mkdir -p "$machine-linux"
${CC:-cc} -std=c11 -O3 $cpu -ffp-contract=off -ffinite-math-only -fno-signed-zeros -fno-trapping-math -fPIC -shared \
  -fvisibility=hidden -Wall -Wextra -I . -I ../../sdk $CFLAGS wide_mean.c -o "$machine-linux/wide_mean.so" -lm
