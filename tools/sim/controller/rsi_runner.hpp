#pragma once

#include <memory>

#include "tools/sim/controller/rsi_session.hpp"

namespace truepose::sim {

/// Starts a session in real time: a thread of its own that sends a datagram at each absolute tick and takes
/// the answers until the next. SCHED_FIFO where that is allowed.
///
/// Throws boost::system::system_error when there is no socket to be had.
std::unique_ptr<RsiSession> start_rsi_runner(const RsiSessionOptions& options, RsiClient client,
                                             RsiListener listener);

}  // namespace truepose::sim
