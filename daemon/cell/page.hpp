#pragma once

#include <boost/json/array.hpp>
#include <boost/json/object.hpp>
#include <cstddef>
#include <vector>

#include "proto/control/param_reader.hpp"

namespace truepose::daemon {

/// The part of a list that a request asks for with "limit" and "offset".
struct Page {
  std::size_t limit;
  std::size_t offset;

  explicit Page(control::ParamReader& read)
      : limit{static_cast<std::size_t>(read.integer("limit", 1, 100).value_or(20))},
        offset{static_cast<std::size_t>(read.integer("offset", 0, 1'000'000'000).value_or(0))} {}

  template <typename Record>
  boost::json::array of(const std::vector<Record>& records,
                        boost::json::object (*json)(const Record&)) const {
    boost::json::array page;
    for (std::size_t i = offset; i < records.size() && page.size() < limit; ++i)
      page.push_back(json(records[i]));
    return page;
  }
};

}  // namespace truepose::daemon
