#pragma once
// The mark of code that runs inside a servo tick.

/// Functions marked ARGIL_REALTIME never allocate, lock, log, wait, throw or make a system call (reading the clock
/// through the vDSO apart), and touch no page for the first time. tests/unit/haptics/realtime_trap_test.cpp traps
/// breaches.
#define ARGIL_REALTIME noexcept
