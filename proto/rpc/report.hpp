#pragma once

#include <boost/json/object.hpp>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "proto/rpc/method.hpp"

namespace truepose::rpc {

/// report.get
struct ReportGet {
  struct Result {
    std::string id{};
    boost::json::object document{};
    std::uint64_t points_total = 0;
  };
  static const Method& method();

  std::optional<std::string> id{};
  std::uint64_t points_offset = 0;
  int points_limit = 0;
};
void layout(Io& io, ReportGet& x);
void layout(Io& io, ReportGet::Result& x);

/// report.html
struct ReportHtml {
  struct Result {
    std::string id{};
    std::uint64_t offset = 0;
    std::string html{};
    std::optional<std::uint64_t> next{};
    std::uint64_t bytes = 0;
    std::string made{};
  };
  static const Method& method();

  std::optional<std::string> id{};
  std::uint64_t offset = 0;
};
void layout(Io& io, ReportHtml& x);
void layout(Io& io, ReportHtml::Result& x);

/// The methods of this file.
std::vector<Described> report_methods();

}  // namespace truepose::rpc
