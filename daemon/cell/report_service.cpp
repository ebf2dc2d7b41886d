#include "daemon/cell/report_service.hpp"

#include <algorithm>
#include <stdexcept>
#include <utility>

#include "daemon/cell/campaign_archive.hpp"
#include "daemon/report/report.hpp"
#include "proto/control/json_text.hpp"

namespace truepose::daemon {

namespace json = boost::json;
using control::ErrorCode;
using control::RpcError;

namespace {

// In a line of at most 64 KiB: JSON makes two bytes of a quote and of the end of a line.
constexpr std::size_t kPartOfPage = 30'000;
constexpr std::size_t kPagesKept = 4;

/// The part that begins there: as much as fits, and no character cut in two.
std::string_view part_of_page(std::string_view page, std::size_t offset) {
  std::string_view part = page.substr(std::min(offset, page.size()));
  if (part.size() <= kPartOfPage) return part;
  std::size_t end = kPartOfPage;
  while (end > 0 && (static_cast<unsigned char>(part[end]) & 0xC0U) == 0x80U) --end;
  return part.substr(0, end);
}

/// @param stream  its status, which the page shows where it has run
std::expected<std::string, std::string> page_of(const std::string& document, const json::object& stream) try {
  auto read = control::parse_json(document);
  if (!read) return std::unexpected("the stored document: " + read.error());
  json::object& calibration = read->as_object();
  if (stream.at("cycles").to_number<std::uint64_t>() > 0) calibration["stream"] = stream;
  return report::render_html(calibration);
} catch (const std::invalid_argument& unusable) {
  return std::unexpected(std::string{"the document cannot be reported: "} + unusable.what());
}

}  // namespace

boost::asio::awaitable<ReportService::Made> ReportService::make(std::string id) {
  auto read = [this, id] { return report_record(parts_.store, id); };
  const auto record = co_await parts_.store_thread.ask(read);
  if (!record) co_return std::unexpected(record.error());
  auto render = [document = record->document, stream = stream_()] { return page_of(document, stream); };
  auto html = co_await parts_.compute_thread.ask(render);
  if (!html) co_return std::unexpected(RpcError{ErrorCode::Internal, html.error()});
  const auto page =
      std::make_shared<const Page>(Page{record->id, control::rfc3339(parts_.wall_clock()), *std::move(html)});
  std::erase_if(pages_, [&](const auto& kept) { return kept->id == page->id; });
  if (pages_.size() == kPagesKept) pages_.pop_front();
  pages_.push_back(page);
  co_return page;
}

Reply<rpc::ReportHtml> ReportService::html(rpc::ReportHtml request) {
  const std::string id = request.id.value_or("");
  // Without an id the parts that follow are of the page whose first was: a campaign may have ended meanwhile.
  const std::string& begun = id.empty() ? begun_unnamed_ : id;
  const auto kept = std::ranges::find_if(pages_, [&](const auto& page) { return page->id == begun; });
  std::shared_ptr<const Page> page;
  if (request.offset > 0 && kept != pages_.end()) {
    page = *kept;
  } else {
    auto made = co_await make(id);
    if (!made) co_return std::unexpected(made.error());
    page = *made;
    if (id.empty()) begun_unnamed_ = page->id;
  }
  const std::string_view part = part_of_page(page->html, request.offset);
  rpc::ReportHtml::Result result{.id = page->id,
                                 .offset = request.offset,
                                 .html = std::string{part},
                                 .bytes = page->html.size(),
                                 .made = page->made};
  if (const std::size_t end = request.offset + part.size(); end < page->html.size()) result.next = end;
  co_return result;
}

}  // namespace truepose::daemon
