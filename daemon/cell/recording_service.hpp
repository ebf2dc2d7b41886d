#pragma once

#include <boost/asio/awaitable.hpp>
#include <expected>
#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "daemon/cell/model_service.hpp"
#include "daemon/recorder/recording_folder.hpp"
#include "proto/recording/recording.hpp"
#include "proto/rpc/cell.hpp"
#include "proto/rpc/recording.hpp"

namespace truepose::daemon {

/// What went over the wires in the last minutes, as an operator has it: written to a file when asked for, and
/// where a fault begins, once a minute at most.
class RecordingService {
 public:
  RecordingService(const CellParts& parts, CellRunner& runner, const DeviceService& devices,
                   const ModelService& models);

  static std::vector<Served<RecordingService>> methods();

  /// Keeps the ring, and writes recordings of faults. Ends when cancelled.
  boost::asio::awaitable<void> watch();
  rpc::CellStatus::Recording status() const;

 private:
  using Saved = std::expected<RecordingFolder::Entry, std::string>;

  Reply<rpc::RecordingSave> save(rpc::RecordingSave);
  Reply<rpc::RecordingList> list(rpc::RecordingList);
  Reply<rpc::RecordingGet> get(rpc::RecordingGet request);

  boost::asio::awaitable<Saved> save_now(std::string reason);
  boost::asio::awaitable<void> save_fault();
  boost::asio::awaitable<void> keep_header();
  void record_fault(const Fault& fault);
  void know_devices();
  recording::Header header(const std::string& reason) const;

  CellParts parts_;
  CellRunner& runner_;
  const DeviceService& devices_;
  const ModelService& models_;
  RecordingFolder folder_;
  std::string ethernet_xml_, nominal_yaml_;
  std::string fault_;       ///< not yet in a recording
  TimePoint next_fault_{};  ///< when one may be recorded
  std::string last_;        ///< name of the recording that was written last
  Identities known_;        ///< of the devices that were connected last
  std::pair<std::string, std::uint64_t> header_kept_{"", UINT64_MAX};  ///< robot's serial, last model
};

}  // namespace truepose::daemon
