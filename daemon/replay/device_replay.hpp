#pragma once

#include <memory>

#include "daemon/replay/replay.hpp"
#include "proto/recording/record.hpp"

namespace truepose::daemon {

/// What a driver's decoders make of the bytes of one connection to the controller (EKI) or the tracker.
class DeviceReplay {
 public:
  explicit DeviceReplay(recording::Wire wire);
  ~DeviceReplay();

  void take(const recording::Record& record);
  /// Records are missing here.
  void miss() { from_its_beginning_ = false; }
  const WireReport& report() const { return report_; }

 private:
  class Decoder;
  void decode(const recording::Record& record);
  void begin();

  WireReport report_;
  std::unique_ptr<Decoder> received_, sent_;
  bool from_its_beginning_ = false;    // the connection: else the first bytes may be no beginning of a frame
  std::optional<ReplayNote> refused_;  // in this connection, which the driver would have ended there
};

}  // namespace truepose::daemon
