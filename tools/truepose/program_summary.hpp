#pragma once

#include <boost/json/fwd.hpp>
#include <string>

#include "proto/krl/places.hpp"
#include "tools/truepose/program_compensation.hpp"

namespace truepose::tools {

/// The files of a program as the operator named them, to say where something stands.
class ProgramPlaces {
 public:
  ProgramPlaces(const krl::ProgramText& text, std::string src, std::string dat, std::string config);

  const std::string& file(krl::Spot spot) const { return names_[static_cast<std::size_t>(spot.file)]; }
  krl::Place place(krl::Spot spot) const { return places_[static_cast<std::size_t>(spot.file)].of(spot.at); }
  /// "P.src:12"
  std::string line(krl::Spot spot) const;
  /// "P.src:12:3"
  std::string line_and_column(krl::Spot spot) const;

 private:
  std::array<std::string, 3> names_;  // in the order of krl::File
  std::array<krl::Places, 3> places_;
};

/// What was done to a program, for a terminal.
std::string program_summary(const ProgramCompensation& done, const ProgramPlaces& places);

/// The same as one document: {"points", "changed", "mean_mm", "mean_deg", "largest_mm", "largest_deg",
/// "changes": [{file, line, name, mm, deg}], "left": [{file, line, name, why, because, absolute}],
/// "notes": [{file, line, text}]}.
boost::json::object program_document(const ProgramCompensation& done, const ProgramPlaces& places);

}  // namespace truepose::tools
