#include <gtest/gtest.h>

#include "config/model_export.hpp"
#include "config/model_file.hpp"
#include "config/robot_file.hpp"
#include "config/text_file.hpp"
#include "core/arm/forward.hpp"
#include "tests/process.hpp"
#include "tests/temp_folder.hpp"

namespace truepose {
namespace {

class Export : public testing::Test {
 protected:
  Export() {
    model_.name = "KR 210";
    model_.cell.robot =
        config::load_robot(std::string(TRUEPOSE_SOURCE_DIR) + "/config/robots/kr210_r2700_2.yaml");
    model_.cell.robot.deviation = {{.joint = 2, .coefficient = 1e-4}};
    model_.parameters = {
        {.name = "joint3.sin1", .value = 1e-4, .sigma = 1e-6, .identified = true, .data_share = 1}};
    file_ = folder_.write("model.yaml", config::model_yaml(model_));
  }
  std::string path(const std::string& name) { return folder_.path() / name; }

  TempFolder folder_;
  config::ModelFile model_;
  std::string file_;
};

TEST_F(Export, WritesUrdfAndParametersOfAModel) {
  const Finished run =
      run_program("truepose", {"export", "--model", file_, "--urdf", path("a.urdf"), "--csv", path("p.csv")});
  EXPECT_EQ(run.exit_code, 0) << run.err;
  EXPECT_EQ(run.out, "");
  EXPECT_EQ(run.err, path("a.urdf") + ": written\n" + path("p.csv") + ": written\n");
  EXPECT_EQ(config::read_text_file(path("a.urdf")), config::urdf(model_.cell.robot));
  EXPECT_EQ(config::read_text_file(path("p.csv")),
            config::parameter_csv(model_.parameters, model_.cell.robot));
}

TEST_F(Export, WritesOneOfThemAlone) {
  EXPECT_EQ(run_program("truepose", {"export", "--model", file_, "--csv", path("p.csv")}).exit_code, 0);
  EXPECT_FALSE(std::filesystem::exists(path("a.urdf")));
}

TEST_F(Export, WritesTheNominalRobotThatImportsToTheSameArm) {
  const Finished run = run_program(
      "truepose", {"robot", "export", "ur10", "--dh", path("dh.csv"), "--standard-dh", path("standard.csv"),
                   "--robodk", path("robodk.csv"), "--urdf", path("arm.urdf")});
  EXPECT_EQ(run.exit_code, 0) << run.err;
  const RobotModel ur10 = config::load_robot("ur10");
  const JointVector q = JointVector::Constant(6, 0.7);
  for (const auto& [file, convention] : {std::pair{"dh.csv", "modified"},
                                         {"standard.csv", "standard"},
                                         {"robodk.csv", "modified"},
                                         {"arm.urdf", ""}}) {
    std::vector<std::string> import{"robot", "import", path(file), "--out", path("arm.yaml")};
    if (*convention != '\0') import.insert(import.end(), {"--dh", convention});
    ASSERT_EQ(run_program("truepose", import).exit_code, 0) << file;
    const RobotModel read = config::load_robot(path("arm.yaml"));
    EXPECT_TRUE(forward_kinematics(read, q).isApprox(forward_kinematics(ur10, q), 1e-9)) << file;
  }
  const Finished nothing = run_program("truepose", {"robot", "export", "ur10"});
  EXPECT_EQ(nothing.exit_code, 2);
  EXPECT_NE(nothing.err.find("--urdf, --dh, --standard-dh, --robodk: missing. Give one of them"),
            std::string::npos);
}

TEST_F(Export, WritesTablesThatImportToTheSameArm) {
  model_.cell.robot.joints[2].a_mm += 0.123;
  model_.cell.robot.joints[2].beta_rad = 1e-3;
  file_ = folder_.write("model.yaml", config::model_yaml(model_));
  const Finished run = run_program("truepose", {"export", "--model", file_, "--dh", path("dh.csv"),
                                                "--robodk", path("robodk.csv"), "--kuka", path("kuka.csv")});
  EXPECT_EQ(run.exit_code, 0) << run.err;
  EXPECT_NE(run.err.find("a DH table has no deviations of joints"), std::string::npos);
  for (const char* table : {"dh.csv", "robodk.csv"}) {
    EXPECT_EQ(run_program("truepose",
                          {"robot", "import", path(table), "--dh", "modified", "--out", path("arm.yaml")})
                  .exit_code,
              0);
    const RobotModel arm = config::load_robot(path("arm.yaml"));
    const JointVector q = JointVector::LinSpaced(6, -1, 1);
    RobotModel geometry = model_.cell.robot;
    geometry.deviation.clear();
    EXPECT_LT(
        (forward_kinematics(arm, q).translation() - forward_kinematics(geometry, q).translation()).norm(),
        1e-9)
        << table;
  }
  EXPECT_EQ(config::read_text_file(path("kuka.csv")),
            config::kuka_corrections_csv(model_.parameters, model_.cell.robot));
}

TEST_F(Export, SaysWhyAFileCannotBeReadOrWritten) {
  const Finished reading =
      run_program("truepose", {"export", "--model", path("no.yaml"), "--csv", path("p")});
  EXPECT_EQ(reading.exit_code, 2);
  EXPECT_EQ(reading.err, "truepose: " + path("no.yaml") + ": cannot be opened: No such file or directory\n");
  const Finished writing = run_program("truepose", {"export", "--model", file_, "--csv", path("no/p.csv")});
  EXPECT_EQ(writing.exit_code, 2);
  EXPECT_EQ(writing.err,
            "truepose: " + path("no/p.csv") + ": cannot be written: No such file or directory\n");
}

TEST_F(Export, RefusesAModelThatWasCutOff) {
  std::string text = config::model_yaml(model_);
  text.erase(text.rfind('\n', text.size() - 2) + 1);
  const std::string file = folder_.write("cut.yaml", text);
  const Finished run = run_program("truepose", {"export", "--model", file, "--csv", path("p.csv")});
  EXPECT_EQ(run.exit_code, 2);
  EXPECT_EQ(run.err,
            "truepose: " + file +
                ": its last line is no 'sha256: ...', which shows that the others are unchanged; identify "
                "again\n");
}

}  // namespace
}  // namespace truepose
