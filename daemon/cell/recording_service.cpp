#include "daemon/cell/recording_service.hpp"

#include <algorithm>

#include "config/model_file.hpp"
#include "config/text_file.hpp"
#include "daemon/cell/file_part.hpp"
#include "daemon/log/log.hpp"
#include "daemon/recorder/stream_settings.hpp"
#include "proto/control/base64.hpp"
#include "proto/control/json_text.hpp"

namespace truepose::daemon {

namespace asio = boost::asio;
using control::ErrorCode;
using control::RpcError;
using namespace std::chrono_literals;

namespace {

constexpr Duration kDrain = 50ms;  // the realtime thread wakes no other thread
constexpr Duration kFromFaultToFault = 1min;
constexpr std::size_t kMostHeaderBytes = std::size_t{4} << 20;

/// The text of the configuration that the stream was made from; empty where it was not made from a file.
std::string text_of_ethernet(const std::filesystem::path& file) try {
  return config::read_text_file(file);
} catch (const config::ConfigError&) {
  return {};
}

/// An arm as a model file.
std::string arm_yaml(const CalibratedCell& cell) {
  return config::model_yaml({.name = cell.robot.name, .cell = cell});
}

recording::Model recorded(const ModelService::Given& given) {
  return {given.number, given.record.id, given.record.sha256, arm_yaml(given.cell)};
}

std::expected<recording::Header, std::string> header_of(const std::filesystem::path& file) try {
  std::string begin(kMostHeaderBytes, '\0');
  std::ifstream in = config::open_own_to_read(file);
  in.read(begin.data(), static_cast<std::streamsize>(begin.size()));
  begin.resize(static_cast<std::size_t>(in.gcount()));
  return recording::Recording::read_header(begin);
} catch (const config::ConfigError& error) {
  return std::unexpected(error.what());
}

using Listed = rpc::RecordingList::Result::Entry;
Listed listed(const RecordingFolder& folder, const RecordingFolder::Entry& entry) {
  const auto header = header_of(folder.find(entry.name));
  return {.name = entry.name,
          .bytes = entry.bytes,
          .date = header ? header->date : "",
          .reason = header ? header->reason : header.error()};
}

}  // namespace

RecordingService::RecordingService(const CellParts& parts, CellRunner& runner, const DeviceService& devices,
                                   const ModelService& models)
    : parts_{parts},
      runner_{runner},
      devices_{devices},
      models_{models},
      folder_{parts.config.recording},
      ethernet_xml_{text_of_ethernet(parts.config.stream.ethernet_xml)},
      nominal_yaml_{arm_yaml({.robot = parts.config.robot.model})} {
  runner_.faults().tell([this](const Fault& fault) { record_fault(fault); });
}

std::vector<Served<RecordingService>> RecordingService::methods() {
  return {&RecordingService::save, &RecordingService::list, &RecordingService::get};
}

Reply<rpc::RecordingSave> RecordingService::save(rpc::RecordingSave) {
  auto saved = co_await save_now("asked for");
  if (!saved) co_return std::unexpected(RpcError{ErrorCode::Store, saved.error()});
  const std::filesystem::path file = parts_.config.recording.folder / saved->name;
  co_return rpc::RecordingSave::Result{.name = saved->name, .bytes = saved->bytes, .file = file.string()};
}

Reply<rpc::RecordingList> RecordingService::list(rpc::RecordingList) {
  auto job = [folder = folder_] {
    rpc::RecordingList::Result result;
    for (const RecordingFolder::Entry& entry : folder.list())
      result.recordings.push_back(listed(folder, entry));
    return result;
  };
  auto result = co_await parts_.recorder_thread.ask(job);
  co_return result;
}

Reply<rpc::RecordingGet> RecordingService::get(rpc::RecordingGet request) {
  auto job = [folder = folder_, name = request.name,
              offset = request.offset]() -> std::expected<std::string, RpcError> {
    const std::filesystem::path file = folder.find(name);
    if (file.empty()) return std::unexpected(RpcError{ErrorCode::NotFound, "no such recording"});
    auto part = part_of(file, offset);
    if (!part) return std::unexpected(RpcError{ErrorCode::Internal, part.error()});
    return *std::move(part);
  };
  const auto part = co_await parts_.recorder_thread.ask(job);
  if (!part) co_return std::unexpected(part.error());
  co_return rpc::RecordingGet::Result{
      .name = request.name, .offset = request.offset, .data = control::base64(*part)};
}

asio::awaitable<RecordingService::Saved> RecordingService::save_now(std::string reason) {
  know_devices();
  const recording::Header header = this->header(reason);
  auto job = [this, header]() -> Saved {
    const std::filesystem::path file = folder_.file(header.date);
    if (auto saved = parts_.recorder.save(header, file); !saved) {
      const std::string why = folder_.why_unusable();
      return std::unexpected(why.empty() ? saved.error() : why);
    }
    std::error_code gone;
    const std::uintmax_t bytes = std::filesystem::file_size(file, gone);
    if (gone) return std::unexpected(file.string() + ": " + gone.message());
    for (const std::string& name : folder_.remove_left_over())
      log_info("recording " + name + " removed: the daemon was killed while it wrote it");
    for (const std::string& name : folder_.prune())
      log_info("recording " + name + " removed: more than the cell file keeps");
    return RecordingFolder::Entry{file.filename(), bytes};
  };
  auto saved = co_await parts_.recorder_thread.ask(job);
  if (saved) last_ = saved->name;
  co_return saved;
}

void RecordingService::record_fault(const Fault& fault) {
  const std::string text = std::string{kind_of(fault.code).code} + ": " + fault.text;
  parts_.recorder.tell(recording::Wire::Daemon, recording::Kind::Fault, text);
  if (fault_.empty()) fault_ = text;
}

asio::awaitable<void> RecordingService::save_fault() {
  next_fault_ = parts_.clock.now() + kFromFaultToFault;
  auto saved = co_await save_now(std::exchange(fault_, {}));
  if (saved) log_warning("what went over the wires until the fault is in recording " + saved->name);
  if (!saved) log_error("the fault was not recorded: " + saved.error());
}

asio::awaitable<void> RecordingService::watch() {
  for (;;) {
    know_devices();
    auto drain = [this] { parts_.recorder.drain(); };
    co_await parts_.recorder_thread.run(drain);
    if (!fault_.empty() && parts_.clock.now() >= next_fault_) co_await save_fault();
    co_await keep_header();
    const TimePoint next = parts_.clock.now() + kDrain;
    co_await parts_.clock.sleep_until(next);
  }
}

/// Where a fault has closed them, they are still what was recorded.
void RecordingService::know_devices() {
  if (devices_.robot().connected()) known_.robot = devices_.robot().identity();
  if (devices_.tracker().connected()) known_.tracker = devices_.tracker().identity();
}

/// For the next process, which finds the ring of one that was killed.
asio::awaitable<void> RecordingService::keep_header() {
  const std::uint64_t model = models_.given().empty() ? 0 : models_.given().back().number;
  const std::pair now{known_.robot.serial, model};
  if (std::exchange(header_kept_, now) == now) co_return;
  auto job = [this, header = header("the daemon was killed")] {
    return parts_.recorder.keep_header(header, folder_);
  };
  auto kept = co_await parts_.recorder_thread.ask(job);
  if (!kept) log_warning("the ring's header: " + kept.error());
}

recording::Header RecordingService::header(const std::string& reason) const {
  recording::Header header{.product = TRUEPOSE_VERSION,
                           .cell = parts_.config.name,
                           .date = control::rfc3339(parts_.wall_clock()),
                           .time_ns = drivers::nanoseconds_of(parts_.clock.now()),
                           .reason = reason,
                           .robot = {known_.robot.model, known_.robot.serial, known_.robot.software},
                           .tracker = {known_.tracker.model, known_.tracker.serial, known_.tracker.firmware},
                           .ethernet_xml = ethernet_xml_,
                           .nominal_yaml = nominal_yaml_,
                           .stream = settings_of(parts_.stream.options())};
  std::ranges::transform(models_.given(), std::back_inserter(header.models), &recorded);
  return header;
}

rpc::CellStatus::Recording RecordingService::status() const {
  const Recorder::Status status = parts_.recorder.status();
  return {.seconds = std::chrono::duration<double>(status.lasts).count(),
          .bytes = status.bytes,
          .dropped = status.dropped,
          .last = text_or_none(last_)};
}

}  // namespace truepose::daemon
