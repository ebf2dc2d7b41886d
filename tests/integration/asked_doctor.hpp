#pragma once

#include <gtest/gtest.h>

#include <boost/json/parse.hpp>
#include <optional>
#include <ostream>
#include <string>
#include <vector>

#include "tests/integration/live_cell.hpp"

namespace truepose {

/// A finding of truepose doctor.
struct Said {
  std::string area, level, finding, next;
};
inline void PrintTo(const Said& said, std::ostream* out) {
  *out << said.level << ' ' << said.area << ' ' << said.finding << "; next: " << said.next << '\n';
}

/// @param exit_code  none: of other cells on this machine it may say
/// anything
inline std::vector<Said> doctor_of(const LiveCell& cell, std::optional<int> exit_code) {
  const Finished doctor = run_program("truepose", {"doctor", "--cell", cell.cell_file(), "--json"});
  EXPECT_EQ(doctor.exit_code, exit_code.value_or(doctor.exit_code)) << doctor.out << doctor.err;
  std::vector<Said> said;
  const boost::json::value findings = boost::json::parse(doctor.out);
  for (const boost::json::value& one : findings.as_array()) {
    const auto text = [&](const char* key) { return std::string{one.at(key).as_string()}; };
    said.push_back({text("area"), text("level"), text("finding"), text("next")});
  }
  return said;
}

}  // namespace truepose
