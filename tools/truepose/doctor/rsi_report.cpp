#include "tools/truepose/doctor/rsi_report.hpp"

#include "proto/record/io.hpp"
#include "tools/truepose/text.hpp"

namespace truepose::tools {

namespace {

std::string names_text(const std::vector<std::string>& elements) {
  std::string names;
  for (const std::string& name : elements) names += (names.empty() ? "" : " ") + name;
  return shown(names);
}

}  // namespace

bool is_of_kind(const RsiSender& sender, const std::optional<rsi::EthernetConfig>& ethernet) {
  if (sender.frames == 0) return false;
  return !ethernet || compare_names(sender.elements, *ethernet) == rsi::NameDifference{};
}

void layout(record::Io& io, SenderReport& x) {
  io("source", x.source);
  io("frames", x.frames);
  io.nullable("frames_per_s", x.frames_per_s);
  io.nullable("cycle_ms", x.cycle_ms);
  io("longest_ms", x.longest_ms);
  io.nullable("ipoc", x.ipoc);
  io.nullable("ipoc_step", x.ipoc_step);
  io.nullable("delay", x.delay);
  io("delay_rises", x.delay_rises);
  io.nullable("decimals", x.decimals);
  io("elements", x.elements);
  io.nullable("unknown", x.unknown);
  io.nullable("missing", x.missing);
  io("malformed", x.malformed);
  io.nullable("why_malformed", x.why_malformed);
}

SenderReport sender_report(const RsiSender& sender, const std::optional<rsi::EthernetConfig>& ethernet) {
  SenderReport report{.source = text(sender.source),
                      .frames = sender.frames,
                      .cycle_ms = sender.cycle_ms(),
                      .longest_ms = std::chrono::duration<double, std::milli>(sender.longest).count(),
                      .delay = sender.frame.delay,
                      .delay_rises = sender.delay_rises(),
                      .elements = sender.elements.names,
                      .malformed = sender.malformed};
  if (report.cycle_ms && *report.cycle_ms > 0) report.frames_per_s = 1000 / *report.cycle_ms;
  if (sender.ipoc_step > 0) report.ipoc_step = sender.ipoc_step;
  if (!sender.why_malformed.empty()) report.why_malformed = sender.why_malformed;
  if (sender.frames == 0) return report;
  report.ipoc = sender.ipoc;
  report.decimals = sender.elements.decimals;
  if (!ethernet) return report;
  rsi::NameDifference names = compare_names(sender.elements, *ethernet);
  report.unknown = std::move(names.unknown);
  report.missing = std::move(names.missing);
  return report;
}

std::string sender_text(const SenderReport& sender) {
  const std::string rises = sender.delay_rises ? ", rising: these cycles had no reply" : "";
  std::vector<Cells> rows{
      {"sender", sender.source},
      {"frames", shown(sender.frames) + ", " + shown(sender.frames_per_s, 1, " a second")},
      {"cycle", "IPOC + " + shown(sender.ipoc_step) + ", " + shown(sender.cycle_ms, 2, " ms") +
                    " by arrival, longest " + shown(sender.longest_ms, 2, " ms")},
      {"IPOC", shown(sender.ipoc)},
      {"Delay", shown(sender.delay) + rises},
      {"decimals", shown(sender.decimals)},
      {"elements", names_text(sender.elements)}};
  if (sender.unknown) rows.push_back({"unknown", names_text(*sender.unknown)});
  if (sender.missing) rows.push_back({"missing", names_text(*sender.missing)});
  rows.push_back({"malformed", shown(sender.malformed)});
  if (sender.why_malformed) rows.back()[1] += ", " + *sender.why_malformed;
  return text_table(rows);
}

std::string sender_line(const RsiSender& sender, std::uint64_t frames) {
  std::string line = text(sender.source) + "  " + std::to_string(frames) + " frames/s";
  if (sender.frames > 0) line += "  IPOC " + std::to_string(sender.ipoc);
  if (sender.frame.delay) line += "  Delay " + std::to_string(*sender.frame.delay);
  if (sender.malformed > 0) line += "  malformed " + std::to_string(sender.malformed);
  return line;
}

}  // namespace truepose::tools
