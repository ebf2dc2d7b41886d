#pragma once

#include <boost/json/object.hpp>
#include <expected>
#include <span>
#include <string>
#include <vector>

#include "core/named.hpp"
#include "core/quality/iso9283.hpp"
#include "proto/record/layout.hpp"

namespace truepose::record {

/// In which frame the attained poses were compared with the commanded ones.
enum class Iso9283Frame {
  AsGiven,  ///< measured in the robot's base already
  Model,    ///< brought there by a calibrated model's base pose
  Fitted,   ///< by a fit over the points: AP is relative
};
inline constexpr std::array kIso9283Frames{Named{"as given", Iso9283Frame::AsGiven},
                                           Named{"model", Iso9283Frame::Model},
                                           Named{"fitted", Iso9283Frame::Fitted}};

/// The document of an ISO 9283 test; mm and rad, angles a, b, c about x, y, z of the base where they are
/// known.
struct Iso9283Document {
  struct Set {
    std::string point, direction, time;
    int cycles = 0;
    SeriesCharacteristics characteristics;  ///< AP, RP
  };
  struct Variation {
    std::string point, time;
    std::vector<std::string> directions;
    AccuracyVariation variation;  ///< vAP
  };
  struct Drift {
    std::string point, direction;
    std::vector<std::string> times;
    PoseDrift drift;  ///< dAP, dRP, moved
  };

  std::string standard = "ISO 9283:1998";
  Iso9283Frame frame = Iso9283Frame::AsGiven;
  int cycles = 0;  ///< the fewest of any pose
  bool complete = false;
  std::vector<std::string> missing;  ///< poses that no cycle came to
  std::vector<Set> sets;
  std::vector<Variation> variations;
  std::vector<Drift> drifts;
};
void layout(Io& io, Iso9283Document& x);

/// Names of the commanded poses that no cycle came to.
std::vector<std::string> poses_without_cycle(std::span<const TestPoint> points);

Iso9283Document iso9283_of(const Iso9283Result& result, std::span<const TestPoint> points,
                           Iso9283Frame frame);
boost::json::object iso9283_document(const Iso9283Document& document);
boost::json::object iso9283_document(const Iso9283Result& result, std::span<const TestPoint> points,
                                     Iso9283Frame frame);
/// @return the document, or one sentence that names the member
std::expected<Iso9283Document, std::string> read_iso9283_document(const boost::json::object& document);

}  // namespace truepose::record
