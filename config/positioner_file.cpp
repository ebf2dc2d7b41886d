#include "config/positioner_file.hpp"

#include <algorithm>
#include <sstream>

#include "config/frame_layout.hpp"
#include "config/sealed_text.hpp"

namespace truepose::config {

/// As it stands in the file, the table as a text.
struct PositionerText {
  PositionerFile of;
  std::string table;
};

void layout(Io& io, PositionerText& x) {
  io("number", x.of.number, kFrameNumber);
  io("arm", x.of.arm);
  io("model", x.of.model, MayBeEmpty{});
  io("root", x.of.X_BR, KukaPose{});
  io("points", x.of.workpiece.points);
  io("readings", x.of.workpiece.readings);
  io.optional("table", x.table);
}

namespace {

constexpr const char* kTableKey = "table: |\n";

}  // namespace

std::string positioner_yaml(const PositionerFile& positioner) {
  std::string text =
      "# A positioner that was measured, and the workpiece on it. root: for ROOT of MACHINE_DEF, mm and deg; model: "
      "when the arm's model was made that it holds for; readings: mm and rad; table: the table's model.\n" +
      yaml_of(PositionerText{positioner, ""}) + kTableKey;
  std::istringstream lines{model_yaml(positioner.table)};
  for (std::string line; std::getline(lines, line);) text += "  " + line + "\n";
  return sealed(text);
}

PositionerFile load_positioner(const std::filesystem::path& file, const ModelFile& model) {
  const YamlValue yaml = parse_sealed(read_text_file(file, kMostBytesOfYaml), file.string(),
                                      DocumentKind::Positioner, "run `truepose positioner` again");
  PositionerText text;
  read_value(yaml, text);
  PositionerFile& positioner = text.of;
  if (positioner.arm != model.name)
    yaml.fail("the positioner of '" + positioner.arm + "', but the arm is '" + model.name + "'");
  if (positioner.model != model.created)
    yaml.fail("measured under the model of " + positioner.model + ", not of " + model.created +
              ": run `truepose positioner` with this model again");
  if (text.table.empty()) yaml.fail("missing key 'table'");
  positioner.table = parse_checked_model(text.table, file.string() + ": table");
  const FrameReadings& workpiece = positioner.workpiece;
  const auto unfit = [&](const FrameReading& reading) {
    return reading.point >= workpiece.points.size() || !reading.p_WS_mm ||
           reading.q.size() != positioner.table.cell.robot.joint_count();
  };
  if (workpiece.readings.empty() || std::ranges::any_of(workpiece.readings, unfit))
    yaml.fail("readings: expected some, each seen of one of the points at " +
              std::to_string(positioner.table.cell.robot.joint_count()) + " joints of the table");
  return std::move(positioner);
}

}  // namespace truepose::config
