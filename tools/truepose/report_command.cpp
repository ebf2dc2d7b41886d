#include "tools/truepose/report_command.hpp"

#include <algorithm>
#include <boost/json.hpp>
#include <boost/system/system_error.hpp>
#include <cstdio>
#include <expected>
#include <fstream>
#include <optional>
#include <sstream>
#include <stdexcept>
#include <utility>
#include <vector>

#include "config/text_file.hpp"
#include "proto/control/json_text.hpp"
#include "tools/report/report.hpp"
#include "tools/truepose/exit_code.hpp"
#include "tools/truepose/rpc_client.hpp"

namespace truepose::tools {
namespace {

namespace json = boost::json;
template <typename T>
using Result = std::expected<T, ClientError>;

constexpr std::int64_t kPage = 50;

Result<json::object> read_document(const std::filesystem::path& file) {
  std::ifstream in{file};
  std::stringstream text;
  text << in.rdbuf();
  if (!in) return std::unexpected(ClientError{kBadInput, file.string() + ": cannot be read"});
  auto value = control::parse_json(text.str());
  if (!value) return std::unexpected(ClientError{kBadInput, file.string() + ": " + value.error()});
  if (!value->is_object())
    return std::unexpected(ClientError{kBadInput, file.string() + ": not a JSON object"});
  return value->as_object();
}

void append(json::object& to, const json::object& page, const char* list) {
  const json::value* more = page.if_contains(list);
  if (more == nullptr) return;
  json::array& points = to[list].is_array() ? to[list].get_array() : to[list].emplace_array();
  for (const json::value& point : more->as_array()) points.push_back(point);
}

/// The campaign's document with all pages of its points, and the stream's counters if it has run.
Result<json::object> fetch_document(const OnlineOptions& online, const std::string& campaign) {
  auto client = RpcClient::connect(online.daemon, online.token_file);
  if (!client) return std::unexpected(client.error());
  json::object document;
  std::string id = campaign;
  for (std::int64_t offset = 0, total = 1; offset < total; offset += kPage) {
    json::object params{{"points_offset", offset}, {"points_limit", kPage}};
    if (!id.empty()) params["id"] = id;
    const auto reply = client->call("report.get", params);
    if (!reply) return std::unexpected(reply.error());
    id = reply->at("id").as_string();
    total = reply->at("points_total").to_number<std::int64_t>();
    const json::object& page = reply->at("document").as_object();
    if (offset == 0) {
      document = page;
      continue;
    }
    append(document, page, "points");
    append(document, page, "remeasured_points");
    append(document, page, "skipped");
  }
  const auto stream = client->call("stream.status", {});
  if (!stream) return std::unexpected(stream.error());
  if (stream->at("cycles").to_number<std::int64_t>() > 0) document["stream"] = *stream;
  return document;
}

Result<int> report(const OnlineOptions& online, const ReportOptions& options) {
  auto document =
      options.document.empty() ? fetch_document(online, options.campaign) : read_document(options.document);
  if (!document) return std::unexpected(document.error());
  if (!options.truth.empty()) {
    auto truth = read_document(options.truth);
    if (!truth) return std::unexpected(truth.error());
    (*document)["truth"] = *std::move(truth);
  }
  std::optional<json::object> iso9283, experiment;
  for (const auto& [file, further] :
       {std::pair{&options.iso9283, &iso9283}, std::pair{&options.experiment, &experiment}}) {
    if (file->empty()) continue;
    auto read = read_document(*file);
    if (!read) return std::unexpected(read.error());
    *further = *std::move(read);
  }
  // Rendered before anything is written, so that a document that cannot be used leaves no file behind.
  const std::string html =
      report::render_html(*document, {iso9283 ? &*iso9283 : nullptr, experiment ? &*experiment : nullptr});
  const std::string table = report::render_text(*document);
  const std::string text = control::json_text(*document) + "\n";
  std::vector<config::TextFile> files;
  if (!options.html.empty()) files.push_back({options.html, html});
  if (!options.json.empty()) files.push_back({options.json, text});
  config::write_together(files);
  std::fputs(online.json ? text.c_str() : table.c_str(), stdout);
  const std::string why = report::why_unusable(*document);
  if (why.empty()) return kDone;
  std::fprintf(stderr, "truepose: %s\n", why.c_str());
  return kFailed;
}

}  // namespace

int report_campaign(const OnlineOptions& online, const ReportOptions& options) try {
  const Result<int> done = report(online, options);
  if (done) return *done;
  std::fprintf(stderr, "truepose: %s\n", done.error().message.c_str());
  return done.error().exit_code;
} catch (const config::ConfigError& error) {
  std::fprintf(stderr, "truepose: %s\n", error.what());
  return kBadInput;
} catch (const std::invalid_argument& unusable) {
  std::fprintf(stderr, "truepose: the document cannot be reported: %s\n", unusable.what());
  return kBadInput;
} catch (const boost::system::system_error& unusable) {
  std::fprintf(
      stderr,
      "truepose: --iso9283 or --experiment: not a document as those commands print it with --json: %s\n",
      unusable.what());
  return kBadInput;
}

}  // namespace truepose::tools
