// Copyright Triaxis contributors.
// SPDX-License-Identifier: Apache-2.0
//
// What main.cpp asks of the bus-functional model.

#ifndef TRIAXIS_VERIF_BURST_BURST_BFM_H_
#define TRIAXIS_VERIF_BURST_BURST_BFM_H_

namespace triaxis {

// True while a burst is under way: the clock may run without a look at Python's triggers.
bool BurstActive();

// Counts a clock cycle of the burst under way.
void CountCycle();

// True where Python has something to do: a burst is over, or a monitor's buffer is filling.
bool WakeRequested();

// The same, and the request is done with.
bool TakeWakeRequest();

}  // namespace triaxis

#endif  // TRIAXIS_VERIF_BURST_BURST_BFM_H_
