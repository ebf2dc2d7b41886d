#include "config/document_kind.hpp"

#include <algorithm>
#include <array>
#include <initializer_list>
#include <string>

namespace truepose::config {
namespace {

/// A document is of a kind where it has all of its keys, which those of no other kind have together.
struct Kind {
  DocumentKind kind;
  const char* name;
  std::array<const char*, 3> keys;  ///< nullptr behind the last
};

constexpr std::array kKinds{
    Kind{DocumentKind::Robot, "a robot file", {"name", "joints"}},
    Kind{DocumentKind::Model, "a model", {"robot", "reflectors", "validation_mean_mm"}},
    Kind{DocumentKind::Tool, "a tool of `truepose tool --out`", {"arm", "frame", "readings"}},
    Kind{DocumentKind::Base, "a base of `truepose base --out`", {"arm", "frame", "model"}},
    Kind{DocumentKind::Positioner, "a positioner of `truepose positioner --out`", {"arm", "root", "model"}},
    Kind{DocumentKind::Cell, "a cell file", {"robot", "stream", "control"}},
    Kind{DocumentKind::Scenario, "a scenario of the simulator", {"robot", "robot_base", "rsi"}},
    Kind{DocumentKind::OpwParameters, "OPW parameters", {"opw_kinematics_geometric_parameters"}},
    Kind{DocumentKind::CalibrationDocument,
         "the JSON document of a calibration",
         {"identify", "parameters", "rank"}},
    Kind{DocumentKind::FrameDocument, "the JSON document of a tool or base", {"frame", "sigma_mm", "krl"}},
    Kind{DocumentKind::PlanDocument, "the JSON document of a plan", {"poses", "predicted", "bound"}}};

const Kind& of(DocumentKind kind) { return *std::ranges::find(kKinds, kind, &Kind::kind); }

bool is_of(const YamlValue& document, const Kind& kind) {
  return std::ranges::all_of(kind.keys, [&](const char* key) { return !key || document.find(key); });
}

}  // namespace

void expect_kind(const YamlValue& document, DocumentKind asked) {
  if (is_of(document, of(asked))) return;
  const auto found = std::ranges::find_if(kKinds, [&](const Kind& kind) { return is_of(document, kind); });
  if (found != kKinds.end()) document.fail(std::string("is ") + found->name + ", not " + of(asked).name);
  if (document.is_text()) document.fail(std::string("is a table (CSV), not ") + of(asked).name);
}

}  // namespace truepose::config
