#pragma once

#include <boost/json/object.hpp>
#include <string>
#include <vector>

#include "proto/krl/places.hpp"
#include "tools/truepose/krl/program_compensation.hpp"

namespace truepose::tools {

/// The files of a program as the operator named them, to say where something stands.
class ProgramPlaces {
 public:
  /// @param names  of its files
  ProgramPlaces(const krl::ProgramText& text, std::vector<std::string> names);

  const std::string& file(krl::Spot spot) const { return names_[spot.file]; }
  krl::Place place(krl::Spot spot) const { return places_[spot.file].of(spot.at); }
  /// "P.src:12"
  std::string line(krl::Spot spot) const;
  /// "P.src:12:3"
  std::string line_and_column(krl::Spot spot) const;

 private:
  std::vector<std::string> names_;
  std::vector<krl::Places> places_;
};

/// What was done to programs, for a terminal. @param title  what was corrected
std::string program_summary(const std::string& title, const ProgramCompensation& done,
                            const ProgramPlaces& places);

/// The same as one document: {"points", "changed", "mean_mm", "mean_deg", "largest_mm", "largest_deg",
/// "changes": [{file, line, name, mm, deg}], "left": [{file, line, name, code, why, what_to_do,
/// because, absolute}], "notes": [{file, line, text}]}.
boost::json::object program_document(const ProgramCompensation& done, const ProgramPlaces& places);

}  // namespace truepose::tools
