// The programs of tests/proto/krl_corpus are written in the styles that real cells have. The table next to
// them says what becomes of each: in the simulated controller, and by `truepose compensate --archive`.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <zip.h>

#include <algorithm>
#include <boost/json.hpp>
#include <fstream>
#include <memory>
#include <regex>
#include <set>
#include <sstream>

#include "config/kuka_archive.hpp"
#include "config/model_file.hpp"
#include "config/robot_file.hpp"
#include "config/scenario.hpp"
#include "core/arm/forward.hpp"
#include "core/simulate/published_arm.hpp"
#include "proto/krl/lexer.hpp"
#include "tests/process.hpp"
#include "tests/temp_folder.hpp"
#include "tools/sim/controller/controller.hpp"
#include "tools/sim/controller/controller_setup.hpp"

namespace truepose::sim {
namespace {

namespace fs = std::filesystem;
namespace json = boost::json;
using namespace std::chrono_literals;
using testing::AllOf;
using testing::HasSubstr;
using testing::IsEmpty;

const fs::path kCorpus = TRUEPOSE_SOURCE_DIR "/tests/proto/krl_corpus";
const fs::path kArchive = kCorpus / "kss87";
const std::string kRobot = TRUEPOSE_SOURCE_DIR "/config/robots/kr210_r2700_2.yaml";

/// What becomes of a program.
struct Row {
  std::string program;
  std::string simulated;  ///< "ended", or the line and the reason where it stops
  std::string corrected;  ///< how many targets of it change, and how many motions to a fixed place do not
  std::string left;       ///< why, each reason once
};

std::ostream& operator<<(std::ostream& out, const Row& row) { return out << row.program; }

std::vector<Row> table() {
  std::vector<Row> rows;
  std::ifstream in(kCorpus / "kss87.tsv");
  std::string line;
  std::getline(in, line);  // the head
  while (std::getline(in, line)) {
    std::istringstream cut(line);
    std::vector<std::string> cells(4);
    for (std::string& cell : cells) std::getline(cut, cell, '\t');
    rows.push_back({cells[0], cells[1], cells[2], cells[3]});
  }
  return rows;
}

config::Scenario cell(const fs::path& archive, const std::string& program) {
  config::Scenario scenario = config::load_scenario(TRUEPOSE_SOURCE_DIR "/config/scenarios/demo.yaml");
  scenario.stream_path.clear();
  scenario.programs.clear();
  scenario.archive = archive;
  scenario.selected = program;
  return scenario;
}

/// Where the arm stands at the end of each motion, and how the program ends.
struct Journey {
  std::string end;
  std::vector<JointVector> stops;
};

Journey run(const fs::path& archive, const std::string& program) {
  Controller controller{controller_setup(cell(archive, program))};
  Journey run;
  std::uint64_t moves = 0;
  for (SimTime passed{0}; passed < 120s;) {
    const auto state = controller.program().state;
    if (state == eki::ProgramState::Ended || state == eki::ProgramState::Stopped) break;
    const SimTime step = std::clamp(controller.next_change().value_or(1ms), SimTime{1}, SimTime{10ms});
    controller.advance(step);
    passed += step;
    if (controller.moves() > moves) run.stops.push_back(controller.axes());
    moves = controller.moves();
  }
  if (controller.program().state == eki::ProgramState::Ended) {
    run.end = "ended";
  } else {
    const std::vector<std::string> messages = controller.take_messages();
    run.end =
        messages.empty() ? "halted" : std::regex_replace(messages.back(), std::regex{"KRC/[^ :]*/"}, "");
  }
  return run;
}

class ArchiveTest : public testing::TestWithParam<Row> {
 protected:
  static void SetUpTestSuite() {
    folder_ = std::make_unique<TempFolder>();
    const RobotModel nominal = config::load_robot(kRobot);
    const config::ModelFile model{.name = nominal.name, .cell = {.robot = with_published_errors(nominal)}};
    const std::string file = folder_->write("model.yaml", config::model_yaml(model));
    corrected_ = folder_->path() / "corrected";
    fs::copy(kArchive, corrected_, fs::copy_options::recursive);
    const Finished done = run_program("truepose", {"compensate", "--robot", kRobot, "--model", file,
                                                   "--archive", kArchive, "--out", corrected_, "--json"});
    EXPECT_EQ(done.exit_code, 1) << done.err;
    document_ = json::parse(done.out).as_object();
  }
  static void TearDownTestSuite() { folder_.reset(); }

  /// Of the program's own file, or of its data list.
  static bool is_of(const json::value& entry, const std::string& program) {
    const std::string stem = fs::path{entry.at("file").as_string().c_str()}.stem();
    return truepose::krl::in_capitals(stem) == krl::in_capitals(program);
  }
  static std::string corrected(const std::string& program) {
    std::size_t changed = 0, left = 0;
    for (const json::value& change : document_.at("changes").as_array()) changed += is_of(change, program);
    for (const json::value& item : document_.at("left").as_array())
      left += is_of(item, program) && item.at("absolute").as_bool();
    return std::to_string(changed) + " and " + std::to_string(left);
  }
  static std::string left(const std::string& program) {
    std::set<std::string> reasons;
    for (const json::value& item : document_.at("left").as_array()) {
      if (is_of(item, program) && item.at("why") != "no motion goes to it")
        reasons.insert(item.at("why").as_string().c_str());
    }
    std::string text;
    for (const std::string& reason : reasons) text += (text.empty() ? "" : "; ") + reason;
    return text;
  }

  static inline std::unique_ptr<TempFolder> folder_;
  static inline fs::path corrected_;
  static inline json::object document_;
};

TEST_P(ArchiveTest, IsRunOrStopsWithTheReasonOfTheTable) {
  EXPECT_EQ(run(kArchive, GetParam().program).end, GetParam().simulated);
}

TEST_P(ArchiveTest, IsCorrectedOrLeftWithTheReasonsOfTheTable) {
  EXPECT_EQ(corrected(GetParam().program), GetParam().corrected);
  EXPECT_EQ(left(GetParam().program), GetParam().left);
}

/// Whether the arm passes by a point: where it comes through a corner is not compared.
bool is_approximated(const std::string& program) {
  for (const config::ArchiveFile& file : config::read_kuka_archive(kArchive)) {
    if (fs::path{file.path}.filename() != program + ".src") continue;
    return std::regex_search(file.text, std::regex{" C_(PTP|DIS|VEL|ORI|SPL)"});
  }
  return false;
}

/// The filter and the simulated controller have no code in common: the real arm under the corrected program
/// stands where the nominal arm does under the one that was given.
TEST_P(ArchiveTest, BringsTheRealArmToWhereTheNominalOneStands) {
  const Row& row = GetParam();
  const bool is_whole = row.simulated == "ended" && row.left.empty() && row.corrected != "0 and 0";
  if (!is_whole || is_approximated(row.program)) return;
  const RobotModel nominal = config::load_robot(kRobot), real = with_published_errors(nominal);
  const Journey before = run(kArchive, row.program), after = run(corrected_, row.program);
  ASSERT_EQ(after.end, "ended");
  ASSERT_EQ(after.stops.size(), before.stops.size());
  const Eigen::Vector3d p_FS{62, -48, 187};
  for (std::size_t i = 0; i < before.stops.size(); ++i) {
    const Eigen::Vector3d wanted = forward_kinematics(nominal, before.stops[i]) * p_FS;
    const Eigen::Vector3d reached = forward_kinematics(real, after.stops[i]) * p_FS;
    EXPECT_LT((wanted - reached).norm(), 0.01) << "motion " << i + 1;
  }
}

INSTANTIATE_TEST_SUITE_P(Corpus, ArchiveTest, testing::ValuesIn(table()),
                         [](const auto& each) { return each.param.program; });

TEST(Corpus, HasARowForEveryProgramWithoutParameters) {
  std::set<std::string> in_table, there;
  for (const Row& row : table()) in_table.insert(row.program);
  for (const config::ArchiveFile& file : config::read_kuka_archive(kArchive)) {
    const fs::path path{file.path};
    const std::string stem = path.stem();
    const bool is_main = file.text.find("DEF " + stem + "()") != std::string::npos;
    if (path.extension() == ".src" && is_main) there.insert(stem);
  }
  there.insert("cell");
  EXPECT_EQ(in_table, there);
  EXPECT_GE(there.size(), 60U);
}

// ---- Archives

void add_to_zip(zip_t* zip, const std::string& name, const std::string& text) {
  zip_source_t* const source = zip_source_buffer(zip, text.data(), text.size(), 0);
  ASSERT_GE(zip_file_add(zip, name.c_str(), source, 0), 0);
}

/// @param separator  of folders in the names: archives of Windows may have backslashes
void write_zip(const fs::path& file, const std::vector<config::ArchiveFile>& files, char separator) {
  zip_t* const zip = zip_open(file.c_str(), ZIP_CREATE | ZIP_EXCL, nullptr);
  ASSERT_NE(zip, nullptr);
  for (const config::ArchiveFile& each : files) {
    std::string name = each.path;
    std::ranges::replace(name, '/', separator);
    add_to_zip(zip, name, each.text);
  }
  const std::string other = "DEFDAT $CONFIG\nENDDAT";
  add_to_zip(zip, "C/KRC/Roboter/Template/other.src", other);
  add_to_zip(zip, "am.ini", other);
  ASSERT_EQ(zip_close(zip), 0);
}

TEST(KukaArchive, IsReadFromAFolderAndFromTheZipOfTheController) {
  const auto files = config::read_kuka_archive(kArchive);
  EXPECT_THAT(files.front().path, HasSubstr("KRC/R1/Mada/$machine.dat"));
  const TempFolder folder;
  for (const char separator : {'/', '\\'}) {
    const fs::path zip = folder.path() / (separator == '/' ? "a.zip" : "b.zip");
    write_zip(zip, files, separator);
    const auto read = config::read_kuka_archive(zip);
    ASSERT_EQ(read.size(), files.size());
    for (std::size_t i = 0; i < files.size(); ++i) {
      EXPECT_EQ(read[i].path, files[i].path);
      EXPECT_EQ(read[i].text, files[i].text);
    }
  }
}

TEST(KukaArchive, MayBeTheFolderR1Itself) {
  const auto all = config::read_kuka_archive(kArchive), r1 = config::read_kuka_archive(kArchive / "KRC/R1");
  EXPECT_EQ(r1.size() + 2, all.size()) << "without STEU";
  EXPECT_EQ(config::read_kuka_archive(kArchive / "KRC").size(), all.size());
}

std::string refusal(const fs::path& archive) {
  try {
    config::read_kuka_archive(archive);
    return "";
  } catch (const config::ConfigError& e) {
    return e.what();
  }
}

TEST(KukaArchive, WithoutProgramsOrThatIsNoneIsRefused) {
  const TempFolder folder;
  EXPECT_THAT(refusal(folder.path()), HasSubstr("no KRL file (.src, .dat). Give the folder that holds KRC"));
  EXPECT_THAT(refusal(folder.write("x.zip", "PK no archive")),
              AllOf(HasSubstr("x.zip: no archive"), HasSubstr("its .zip")));
  EXPECT_THAT(refusal(folder.path() / "nowhere"), HasSubstr("nowhere"));
}

/// Its own sps.sub does not call the state server, without which no client sees the controller.
TEST(ArchiveOnTheController, IsServedByTheStateServer) {
  Controller controller{controller_setup(cell(kArchive, "TIMERS"))};
  controller.advance(1s);
  EXPECT_TRUE(controller.is_open("CellState"));
  for (const krl::Fault& fault : controller.not_simulated()) EXPECT_FALSE(fault.what.empty()) << fault.text();
}

}  // namespace
}  // namespace truepose::sim
