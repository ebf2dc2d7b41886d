#include "daemon/replay/replay.hpp"

#include <algorithm>
#include <charconv>
#include <utility>

#include "daemon/replay/stream_replay.hpp"

namespace truepose::daemon {

using recording::Kind;
using recording::Record;
using recording::Wire;

std::expected<ReplayReport, std::string> replay(const recording::Recording& recording) {
  auto stream = StreamReplay::create(recording.header());
  if (!stream) return std::unexpected(stream.error());
  ReplayReport report;
  const auto take = [&](const Record& record) {
    if (report.records++ == 0) report.begin_ns = report.end_ns = record.time_ns;
    report.begin_ns = std::min(report.begin_ns, record.time_ns);
    report.end_ns = std::max(report.end_ns, record.time_ns);
    if (record.kind == Kind::Dropped) {
      std::uint64_t dropped = 0;
      std::from_chars(record.bytes.data(), record.bytes.data() + record.bytes.size(), dropped);
      report.dropped += dropped;
      stream->miss();
    } else if (record.kind == Kind::Fault) {
      report.recorded_faults.push_back({record.time_ns, record.bytes});
    } else if (record.wire == Wire::Rsi) {
      stream->take(record);
    }
  };
  report.damage = recording.for_each(take);
  stream->end();
  report.stream = stream->report();
  return report;
}

}  // namespace truepose::daemon
