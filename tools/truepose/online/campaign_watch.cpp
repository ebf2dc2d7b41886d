#include "tools/truepose/online/campaign_watch.hpp"

#include <unistd.h>

#include <algorithm>
#include <array>
#include <csignal>

#include "core/formatted.hpp"
#include "proto/rpc/events.hpp"
#include "tools/truepose/online/online_commands.hpp"
#include "tools/truepose/online/online_text.hpp"
#include "tools/truepose/text.hpp"

namespace truepose::tools {

namespace {

bool is_over(const std::string& phase) {
  return phase == "done" || phase == "aborted" || phase == "failed" || phase == "interrupted";
}

/// Shows what happens, line by line, and progress: on a terminal as the last line, which is written over.
class Display {
 public:
  explicit Display(bool silent) : silent_{silent}, overwrite_{::isatty(STDOUT_FILENO) == 1} {}
  void show(const rpc::CampaignProgress& progress) {
    const bool last = is_over(progress.phase);
    line_ = progress_line(progress) + (overwrite_ && !last ? "" : "\n");
    write(line_);
  }
  void tell(const control::Event& event, const std::string& what) {
    constexpr std::size_t kDate = 11, kTime = 8;  // of 2026-01-31T12:00:00.000Z, and of the local time
    std::string time = shown_time(event.time);
    if (time.size() > kDate) time = time.substr(kDate, kTime);
    write(time + "  " + what + "\n");
    if (overwrite_) write(line_);
  }

 private:
  void write(const std::string& text) const {
    if (!silent_) print((overwrite_ ? "\r\x1b[K" : "") + text);
  }

  bool silent_;
  bool overwrite_;
  std::string line_;
};

/// Text of an event other than progress; empty: it does not belong to a campaign.
std::string event_text(const control::Event& event) {
  if (event.topic == "log") {
    const auto line = record::from_json<rpc::LogLine>(event.data);
    return line && line->level == "warning" ? line->text : "";
  }
  if (event.topic != "cell") return {};
  const auto cell = record::from_json<rpc::StateChanged>(event.data);
  const bool concerns =
      cell && (cell->state == "campaign" || cell->state == "paused" || cell->state == "fault");
  return concerns ? cell->reason : "";
}

/// Says at an interruption what continues without this program.
class InterruptNotice {
 public:
  explicit InterruptNotice(const std::string& id) {
    text() = formatted(
        "\ncampaign %s continues. Follow it: truepose campaign watch\nEnd it: truepose campaign abort\n",
        id.c_str());
    std::signal(SIGINT, &say);
  }
  ~InterruptNotice() { std::signal(SIGINT, SIG_DFL); }
  InterruptNotice(const InterruptNotice&) = delete;
  InterruptNotice& operator=(const InterruptNotice&) = delete;

 private:
  static std::string& text() {
    static std::string text;
    return text;
  }
  static void say(int signal) {
    [[maybe_unused]] const auto written = ::write(STDERR_FILENO, text().data(), text().size());
    std::signal(signal, SIG_DFL);
    std::raise(signal);
  }
};

std::string model_text_of(RpcClient& client, const std::string& id) {
  const rpc::ModelSummary model = value_or_throw(client.call(rpc::ModelGet{.id = id})).record.model;
  return "model " + id + ", " + shown(model.validation_after_mm, 3, " mm") + " on validation poses, " +
         (model.active ? "active" : "not active");
}

/// The command that a campaign without a model was for.
std::string next_after(const std::string& kind, const std::string& id) {
  if (kind == "tool") return "truepose tools activate " + id;
  if (kind == "base") return "truepose campaign export " + id + " --frame base.yaml";
  return "truepose campaign show " + id;
}

/// Reports what happens to the campaign if the daemon is gone.
control::Event next_event(RpcClient& client) {
  auto event = client.next_event();
  if (!event)
    throw CommandError{
        event.error().exit_code,
        event.error().message + "; what the campaign has measured is kept: truepose status has its progress"};
  return *std::move(event);
}

}  // namespace

void subscribe_to_watch(RpcClient& client) {
  using enum control::Topic;
  value_or_throw(client.call(rpc::EventsSubscribe{.topics = {{Campaign, Cell, Log}}}));
}

Received<rpc::CampaignProgress> watch_to_end(RpcClient& client, const rpc::CampaignProgress& begun,
                                             bool silent) {
  const InterruptNotice notice{begun.id};
  Display display{silent};
  display.show(begun);
  Received<rpc::CampaignProgress> progress{record::to_json(begun), begun};
  while (!is_over(progress.record.phase)) {
    const control::Event event = next_event(client);
    if (const std::string what = event_text(event); !what.empty()) display.tell(event, what);
    if (event.topic != "campaign") continue;
    auto next = value_or_throw(received<rpc::CampaignProgress>(event.data, "event campaign"));
    if (next.record.id != begun.id) continue;
    progress = std::move(next);
    display.show(progress.record);
  }
  return progress;
}

std::string ending_text(RpcClient& client, const rpc::CampaignProgress& progress) {
  const std::string &id = progress.id, &phase = progress.phase;
  if (phase == "interrupted")
    return "campaign " + id + " was interrupted; what it measured is kept\nnext: truepose campaign resume " +
           id + ", or truepose campaign abort " + id + "\n";
  if (phase != "done")
    return "campaign " + id + " " + phase + "; what it measured is kept\nnext: truepose campaign show " + id +
           "\n";
  if (!progress.model_id) return "campaign " + id + " is done\nnext: " + next_after(progress.kind, id) + "\n";
  return "campaign " + id + " is done: " + model_text_of(client, *progress.model_id) +
         "\nnext: truepose report " + id + " --html report.html\n";
}

}  // namespace truepose::tools
