#pragma once

#include <cstddef>
#include <functional>

namespace truepose {

/// Whether `work` comes to its end without a system call (those that the kernel's vDSO answers, as for the
/// time, are none): it runs in a child process whose first one ends it. Not under a sanitizer, which makes
/// its own.
bool makes_no_system_call(const std::function<void()>& work);

/// Calls of pthread_mutex_lock of this thread so far, those of std::mutex included.
std::size_t locks();

}  // namespace truepose
