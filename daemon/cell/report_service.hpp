#pragma once

#include <boost/json/object.hpp>
#include <deque>
#include <expected>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "daemon/cell/service.hpp"
#include "proto/rpc/report.hpp"

namespace truepose::daemon {

/// Shows calibrations as people read them: the page that `truepose report --html` writes, in parts that fit
/// into a line of the protocol.
class ReportService {
 public:
  /// @param stream  its status
  ReportService(const CellParts& parts, std::function<boost::json::object()> stream)
      : parts_{parts}, stream_{std::move(stream)} {}

  static std::vector<Served<ReportService>> methods() { return {&ReportService::html}; }

 private:
  /// A page that was made, for who asks for its parts one after the other.
  struct Page {
    std::string id;    ///< of the campaign
    std::string made;  ///< RFC 3339
    std::string html;
  };
  using Made = std::expected<std::shared_ptr<const Page>, control::RpcError>;

  Reply<rpc::ReportHtml> html(rpc::ReportHtml request);
  boost::asio::awaitable<Made> make(std::string id);

  CellParts parts_;
  std::function<boost::json::object()> stream_;
  std::deque<std::shared_ptr<const Page>> pages_;  ///< made last, the newest at the end
  std::string begun_unnamed_;                      ///< campaign of the page last begun without an id
};

}  // namespace truepose::daemon
