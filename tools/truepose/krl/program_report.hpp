#pragma once

#include <concepts>
#include <string>
#include <vector>

#include "proto/krl/places.hpp"
#include "proto/record/layout.hpp"
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

template <class Item>
concept HasPlace = std::same_as<Item, krl::Spot> || requires(const Item& item) {
  item.spot;
};
/// Something of a program, in a document with its file and line.
template <HasPlace Item>
struct Placed {
  Item item;
  const ProgramPlaces& places;
};
struct InFiles {
  const ProgramPlaces& places;
  template <HasPlace Item>
  Placed<Item> form_of(const Item& item) const {
    return {item, places};
  }
};
void layout(record::Io& io, Placed<krl::ProgramFault>& x);

/// The same as one document.
struct ProgramDocument {
  ProgramCompensation done;
  const ProgramPlaces& places;
};
void layout(record::Io& io, ProgramDocument& x);

}  // namespace truepose::tools
