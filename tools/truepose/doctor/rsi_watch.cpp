#include "tools/truepose/doctor/rsi_watch.hpp"

#include <algorithm>
#include <utility>

#include "daemon/realtime/stream_status.hpp"

namespace truepose::tools {

namespace {

void take_frame(RsiSender& sender, rsi::RobotFrame frame, std::string_view bytes) {
  if (sender.frames++ == 0) {
    sender.ipoc_begin = frame.ipoc;
    sender.delay_begin = frame.delay;
  } else if (frame.ipoc > sender.ipoc) {
    const std::uint64_t step = frame.ipoc - sender.ipoc;
    sender.ipoc_step = sender.ipoc_step == 0 ? step : std::min(sender.ipoc_step, step);
  }
  sender.ipoc = frame.ipoc;
  sender.frame = std::move(frame);
  if (auto elements = rsi::frame_elements(bytes)) sender.elements = *std::move(elements);
}

void take_malformed(RsiSender& sender, const std::string& why, std::size_t at, std::string_view bytes) {
  ++sender.malformed;
  sender.why_malformed = why + ": " + daemon::Excerpt::of(bytes, at).text();
}

}  // namespace

std::optional<double> RsiSender::cycle_ms() const {
  const std::uint64_t all = frames + malformed;
  if (all < 2) return std::nullopt;
  return std::chrono::duration<double, std::milli>(last - first).count() / static_cast<double>(all - 1);
}

void RsiWatch::take(const drivers::Datagram& datagram, bool cut) {
  const std::pair key{datagram.source.address, datagram.source.port};
  if (!senders_.contains(key) && senders_.size() == kMostSenders) return;
  RsiSender& sender = senders_[key];
  if (sender.frames + sender.malformed == 0) {
    sender.source = datagram.source;
    sender.first = datagram.received;
  } else {
    const drivers::Duration gap = datagram.received - sender.last;
    sender.longest = std::max(sender.longest, gap);
    sender.shortest = std::min(sender.shortest.value_or(gap), gap);
  }
  sender.last = datagram.received;
  if (cut) return take_malformed(sender, "longer than 64 KB", 0, datagram.bytes);
  auto frame = rsi::decode_robot_frame(datagram.bytes);
  if (!frame) return take_malformed(sender, describe(frame.error()), frame.error().offset, datagram.bytes);
  ++frames_;
  take_frame(sender, *std::move(frame), datagram.bytes);
}

std::vector<RsiSender> RsiWatch::senders() const {
  std::vector<RsiSender> senders;
  for (const auto& [key, sender] : senders_) senders.push_back(sender);
  return senders;
}

}  // namespace truepose::tools
