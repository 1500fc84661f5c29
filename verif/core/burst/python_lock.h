// Copyright Triaxis contributors.
// SPDX-License-Identifier: Apache-2.0
//
// cocotb keeps Python's lock in the simulator's thread, also while no Python runs in it. A burst needs no
// Python, and the worker thread does: so the lock is given away for its time. libpython is loaded by
// cocotb at run time, hence the look-up by name.

#ifndef TRIAXIS_VERIF_BURST_PYTHON_LOCK_H_
#define TRIAXIS_VERIF_BURST_PYTHON_LOCK_H_

#include <dlfcn.h>

namespace triaxis {

// Gives Python's lock away, if this thread has it, until the end of the scope.
class WithoutPythonLock {
   public:
    WithoutPythonLock() {
        static const auto has_lock = Find<int (*)()>("PyGILState_Check");
        static const auto give_away = Find<void* (*)()>("PyEval_SaveThread");
        if (has_lock && give_away && has_lock()) state_ = give_away();
    }
    ~WithoutPythonLock() {
        static const auto take_back = Find<void (*)(void*)>("PyEval_RestoreThread");
        if (state_ && take_back) take_back(state_);
    }
    WithoutPythonLock(const WithoutPythonLock&) = delete;
    WithoutPythonLock& operator=(const WithoutPythonLock&) = delete;

   private:
    template <typename Function>
    static Function Find(const char* name) {
        return reinterpret_cast<Function>(dlsym(RTLD_DEFAULT, name));
    }
    void* state_ = nullptr;
};

}  // namespace triaxis

#endif  // TRIAXIS_VERIF_BURST_PYTHON_LOCK_H_
