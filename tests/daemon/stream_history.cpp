#include "tests/daemon/stream_history.hpp"

namespace truepose::daemon {

StreamHistory stream_history(std::uint64_t seed) {
  StreamCell cell{seed};
  for (int cycle = 0; cycle < 900; ++cycle) cell.cycle();
  return cell.history();
}

}  // namespace truepose::daemon
