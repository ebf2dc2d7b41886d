#pragma once

#include <boost/json/object.hpp>
#include <span>
#include <string_view>

#include "core/judge/iso9283.hpp"

namespace truepose::control {

/// In which frame the attained poses were compared with the commanded ones.
enum class Iso9283Frame {
  AsGiven,  ///< measured in the robot's base already
  Model,    ///< brought there by a calibrated model's base pose
  Fitted,   ///< by a fit over the points: AP is relative
};
std::string_view name_of(Iso9283Frame frame);

/// {"standard","frame","cycles","complete","sets":[{"point","direction","time","cycles","AP":{"p","x","y","z"
/// [,"a","b","c"]},"RP":{"l","mean","std"[,"a","b","c"]}}],"variations":[{"point","time","directions","vAP"}],
/// "drifts":[{"point","direction","times","dAP","dRP","moved"}]}; mm and rad, a, b, c about
/// x, y, z of the base.
boost::json::object iso9283_document(const Iso9283Result& result, std::span<const TestPoint> points,
                                     Iso9283Frame frame);

}  // namespace truepose::control
