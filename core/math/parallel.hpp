#pragma once

#include <functional>

namespace truepose {

/// Calls work(0) .. work(count - 1), each once, on up to `jobs` threads, the calling one among them, and
/// returns once all have ended.
///
/// Which thread takes which is open: where each call writes what is its own alone, the results are the same
/// for any number of jobs. What a call throws ends the loop early; of several, that of the lowest number is
/// thrown again. Threads count their steps where the calling one does.
void parallel_for(int count, int jobs, const std::function<void(int)>& work);

/// Processors that this process may use.
int processor_count();

}  // namespace truepose
