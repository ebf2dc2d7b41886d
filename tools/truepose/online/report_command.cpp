#include <boost/json.hpp>
#include <optional>
#include <stdexcept>
#include <utility>

#include "config/path_file.hpp"
#include "config/text_file.hpp"
#include "daemon/report/report.hpp"
#include "proto/control/json_text.hpp"
#include "proto/record/json_io.hpp"
#include "proto/rpc/stream.hpp"
#include "tools/truepose/online/campaign_source.hpp"
#include "tools/truepose/online/online_commands.hpp"
#include "tools/truepose/online/report_output.hpp"
#include "tools/truepose/text.hpp"

namespace truepose::tools {
namespace {

namespace json = boost::json;

json::object read_document(const std::filesystem::path& file) {
  const auto value = control::parse_json(config::read_text_file(file));
  if (!value) throw CommandError{kBadInput, file.string() + ": " + value.error()};
  if (!value->is_object()) throw CommandError{kBadInput, file.string() + ": not a JSON object"};
  return value->as_object();
}

std::optional<json::object> read_if_given(const std::filesystem::path& file) {
  return file.empty() ? std::nullopt : std::optional{read_document(file)};
}

/// @param path  that is to be judged too, or empty
CommandError without_daemon(CommandError error, const std::filesystem::path& path) {
  if (error.exit_code == kUnreachable && !path.empty())
    error.message += "; without a daemon, judge " + path.string() +
                     " by --robot FILE --model FILE, by --document FILE or by --store FILE";
  return error;
}

/// The campaign's document, and the stream's counters if it has run.
json::object fetch_document(const OnlineOptions& online, const ReportOptions& options) {
  json::object document = whole_report(*campaign_source(online, {options.store, {}}), options.campaign);
  if (!options.store.empty()) return document;
  RpcClient client = value_or_throw(RpcClient::connect(online));
  auto [json, stream] = value_or_throw(client.call(rpc::GetStreamStatus{}));
  if (stream.cycles > 0) document["stream"] = std::move(json);
  return document;
}

/// What a production program did, by where the document's calibration has tracker and reflector.
json::object production_of(const std::filesystem::path& file, const json::object& document) {
  const auto calibration = record::read_calibration_document(document);
  if (!calibration) throw std::invalid_argument{"calibration document: " + calibration.error()};
  if (!calibration->base || !calibration->arm || calibration->smr.size() != 1)
    throw CommandError{
        kBadInput,
        file.string() + ": can only be judged by a calibration with its arm, a base and one reflector"};
  return record::to_json(record::production_of(config::load_production_path(
      file, {calibration->base->isometry(), calibration->smr.front().p_FS_mm, calibration->arm->robot()})));
}

}  // namespace

int report_campaign(const OnlineOptions& online, const ReportOptions& options) try {
  json::object document =
      options.document.empty() ? fetch_document(online, options) : read_document(options.document);
  if (auto truth = read_if_given(options.truth)) document["truth"] = *std::move(truth);
  if (!options.path.empty()) document["production"] = production_of(options.path, document);
  const auto iso9283 = read_if_given(options.iso9283), frame = read_if_given(options.frame);
  // Rendered before anything is written, so that a document that cannot be used leaves no file behind.
  const report::ReportDocument read{document};
  deliver({report::render_html(read, {iso9283 ? &*iso9283 : nullptr, frame ? &*frame : nullptr}),
           with_shown_verdict(report::render_text(read)), document},
          options, online.json);
  if (std::string why = report::why_unusable(read); !why.empty()) throw CommandError{kFailed, std::move(why)};
  return kDone;
} catch (const CommandError& error) {
  throw without_daemon(error, options.path);
} catch (const std::invalid_argument& unusable) {
  throw CommandError{kBadInput, std::string{"the document cannot be reported: "} + unusable.what()};
}

}  // namespace truepose::tools
