#include "tools/proxy/faulty_way.hpp"

#include <algorithm>
#include <utility>

namespace truepose::proxy {

// Two states, of which one loses all: bursts of the mean length b, and of all datagrams the share p.
// Source: Gilbert, Capacity of a Burst-Noise Channel (1960).
bool FaultyWay::is_lost() {
  const double burst = std::max(faults.burst, 1.0);
  if (faults.loss <= 0 || faults.loss >= 1) {
    losing_ = faults.loss >= 1;
  } else if (losing_) {
    losing_ = !happens(1 / burst);
  } else {
    losing_ = happens(faults.loss / (burst * (1 - faults.loss)));
  }
  return losing_;
}

FaultyWay::Outgoing FaultyWay::damaged(std::string_view bytes) {
  Outgoing out{std::string{bytes}, std::chrono::microseconds{static_cast<std::int64_t>(
                                       (faults.delay_ms + faults.jitter_ms * random_.uniform()) * 1000)}};
  if (happens(faults.truncate) && !out.bytes.empty()) {
    out.bytes.resize(random_.next() % out.bytes.size());
    ++counters_.truncated;
  }
  if (happens(faults.corrupt) && !out.bytes.empty()) {
    const std::size_t at = random_.next() % out.bytes.size();
    out.bytes[at] = static_cast<char>(out.bytes[at] ^ static_cast<char>(1 + random_.next() % 255));
    ++counters_.corrupted;
  }
  out.bytes.append(static_cast<std::size_t>(faults.nul_bytes), '\0');
  return out;
}

std::vector<FaultyWay::Outgoing> FaultyWay::datagram(std::string_view bytes) {
  ++counters_.received;
  counters_.bytes += bytes.size();
  if (is_lost()) {
    ++counters_.lost;
    return {};
  }
  std::vector<Outgoing> out{damaged(bytes)};
  if (happens(faults.duplicate)) {
    out.push_back(out.front());
    ++counters_.duplicated;
  }
  if (held_back_) {
    out.push_back(*std::exchange(held_back_, std::nullopt));
  } else if (happens(faults.reorder)) {
    held_back_ = std::move(out.back());
    out.pop_back();
    ++counters_.reordered;
  }
  counters_.forwarded += out.size();
  return out;
}

FaultyWay::Outgoing FaultyWay::piece(std::string_view bytes) {
  ++counters_.received;
  counters_.bytes += bytes.size();
  ++counters_.forwarded;
  return damaged(bytes);
}

}  // namespace truepose::proxy
