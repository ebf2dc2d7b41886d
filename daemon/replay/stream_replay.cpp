#include "daemon/replay/stream_replay.hpp"

#include <algorithm>
#include <cstring>
#include <utility>

#include "config/model_file.hpp"
#include "daemon/recorder/stream_settings.hpp"

namespace truepose::daemon {

using recording::Commands;
using recording::Kind;
using recording::Record;

namespace {

constexpr const char* kBegunBefore =
    "it begins within the life of a stream: until the replayed one is ramped in";
constexpr const char* kIncomplete = "records are missing: until the next checkpoint";

std::optional<StreamMemory::Record> memory_in(const std::string& bytes) {
  StreamMemory::Record memory;
  if (bytes.size() != sizeof memory) return std::nullopt;
  std::memcpy(&memory, bytes.data(), sizeof memory);
  return memory;
}

using Counter = std::uint64_t StreamCounters::*;
constexpr std::array kCounters{Named<Counter>{"datagrams", &StreamCounters::datagrams},
                               Named<Counter>{"answered", &StreamCounters::answered},
                               Named<Counter>{"held", &StreamCounters::held},
                               Named<Counter>{"duplicate", &StreamCounters::duplicate},
                               Named<Counter>{"wrong_ipoc", &StreamCounters::wrong_ipoc},
                               Named<Counter>{"unconfirmed", &StreamCounters::unconfirmed},
                               Named<Counter>{"unanswered", &StreamCounters::unanswered},
                               Named<Counter>{"malformed", &StreamCounters::malformed},
                               Named<Counter>{"partly_read", &StreamCounters::partly_read},
                               Named<Counter>{"unexpected_sender", &StreamCounters::unexpected_sender},
                               Named<Counter>{"no_solution", &StreamCounters::no_solution},
                               Named<Counter>{"damped", &StreamCounters::damped},
                               Named<Counter>{"lost", &StreamCounters::lost},
                               Named<Counter>{"late", &StreamCounters::late}};

bool steady(StreamState state) { return state == StreamState::Active || state == StreamState::Idle; }

}  // namespace

std::expected<StreamReplay, std::string> StreamReplay::create(const recording::Header& header) try {
  auto ethernet = rsi::parse_ethernet_config(header.ethernet_xml);
  if (!ethernet) return std::unexpected("header: ethernet_xml: " + ethernet.error());
  auto options = options_of(header.stream);
  if (!options) return std::unexpected("header: " + options.error());
  RobotModel nominal = config::parse_model(header.nominal_yaml, "header: nominal_yaml").cell.robot;
  if (auto why = why_unfit(nominal, *ethernet, *options)) return std::unexpected("header: " + *why);
  Models models;
  for (const recording::Model& model : header.models) {
    const CalibratedCell& cell = models[model.number] =
        config::parse_model(model.yaml, "header: model " + model.id).cell;
    if (cell.reflectors.empty())
      return std::unexpected("header: model " + model.id + " has no point to keep");
  }
  return StreamReplay{std::move(nominal), *std::move(ethernet), *options, std::move(models)};
} catch (const config::ConfigError& error) {
  return std::unexpected(error.what());
}

void StreamReplay::take(const Record& record) {
  switch (record.kind) {
    case Kind::Started:
      begin(record);
      caught_up_ = true;
      break;
    case Kind::Checkpoint:
      if (!cycle_) begin(record);
      break;
    case Kind::Commands:
      command(record);
      break;
    case Kind::Received:
      datagram_ = record;
      break;
    case Kind::Sent:
      answer(record);
      break;
    default:
      break;
  }
}

void StreamReplay::begin(const Record& record) {
  end();
  options_.listening_since = drivers::time_of(record.time_ns);
  memory_ = StreamMemory::in_process();
  if (const auto memory = memory_in(record.bytes)) memory_->keep(*memory);
  cycle_ = StreamCycle::create(nominal_, ethernet_, options_, memory_.get()).value();
  commands_ = {};
  model_known_ = true;
  caught_up_ = false;
}

void StreamReplay::miss() {
  if (cycle_) explain(kIncomplete);
  end();
  datagram_.reset();
}

void StreamReplay::command(const Record& record) {
  const auto commands = recording::read_commands(record.bytes);
  if (!cycle_ || !commands) return;
  const Commands before = std::exchange(commands_, *commands);
  if (commands->engagement == Commands::Engagement::Off) cycle_->disengage();
  if (commands->engagement == Commands::Engagement::Leaving) cycle_->leave();
  if (commands->engagement == Commands::Engagement::On) cycle_->engage();
  if (commands->engagement == Commands::Engagement::Armed) cycle_->arm();
  if (commands->acknowledged != before.acknowledged) cycle_->acknowledge();
  if (commands->models == before.models) return;
  const auto model = models_.find(commands->model);
  model_known_ = commands->model == 0 || model != models_.end();
  if (!model_known_) {
    caught_up_ = false;
    explain("model " + std::to_string(commands->model) + " is not in the recording: while it was active");
  }
  if (model == models_.end()) return cycle_->use_no_model();
  cycle_->use_model(model->second.robot, model->first, model->second.reflectors.front().p_FS_mm);
}

void StreamReplay::answer(const Record& sent) {
  const auto datagram = std::exchange(datagram_, std::nullopt);
  if (!datagram) return;
  if (!cycle_) return explain(kBegunBefore);
  const recording::Endpoint peer = datagram->peer.value_or(recording::Endpoint{});
  const std::string_view reply =
      cycle_->answer({datagram->bytes, {peer.address, peer.port}, drivers::time_of(datagram->time_ns)});
  const drivers::TimePoint received = drivers::time_of(datagram->time_ns);
  const drivers::TimePoint done = drivers::time_of(sent.time_ns);
  cycle_->finish({received, received, done, done, {}, !reply.empty()});
  ++report_.datagrams;
  take_events(datagram->time_ns);
  if (!caught_up_ && model_known_) {
    explain(kBegunBefore);
    caught_up_ = steady(cycle_->circumstances().state);
  } else if (caught_up_) {
    compare(sent, reply);
  }
}

void StreamReplay::compare(const Record& sent, std::string_view reply) {
  ++report_.compared;
  if (reply == sent.bytes) return;
  ++report_.different;
  if (report_.first_different) return;
  const auto quoted = [](std::string_view bytes) {
    return bytes.empty() ? std::string{"no reply"} : std::string{bytes};
  };
  report_.first_different = {sent.time_ns, "recorded: " + quoted(sent.bytes) + "; now: " + quoted(reply)};
}

void StreamReplay::take_events(std::int64_t time_ns) {
  for (StreamEvent event; cycle_->next_event(event);) {
    if (event.kind == StreamEventKind::Malformed && !report_.first_rejected)
      report_.first_rejected = {time_ns, describe(event)};
    const bool faulted = event.state == StreamState::Fault || event.state == StreamState::Frozen;
    if (event.kind == StreamEventKind::StateChanged && faulted)
      report_.faults.push_back({time_ns, describe(event)});
  }
}

void StreamReplay::end() {
  if (!cycle_) return;
  const StreamStatus status = cycle_->status();
  for (const auto& [name, counter] : kCounters)
    report_.counters[std::string{name}] += status.counters.*counter;
  report_.rejected += status.counters.malformed;
  report_.sessions += status.counters.sessions;
  report_.max_step_deg = std::max(report_.max_step_deg, status.max_step_deg);
  cycle_.reset();
}

void StreamReplay::explain(const std::string& why) {
  if (std::ranges::find(report_.not_compared, why) == report_.not_compared.end())
    report_.not_compared.push_back(why);
}

}  // namespace truepose::daemon
