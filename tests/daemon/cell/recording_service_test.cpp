#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <boost/json/value.hpp>
#include <set>

#include "config/text_file.hpp"
#include "daemon/recorder/recording_folder.hpp"
#include "proto/control/base64.hpp"
#include "proto/recording/recording.hpp"
#include "tests/daemon/as_nobody.hpp"
#include "tests/daemon/cell_fixture.hpp"

namespace truepose::daemon {
namespace {

using namespace std::chrono_literals;
namespace json = boost::json;
using testing::ElementsAre;
using testing::HasSubstr;

struct ARecordedCellService : CellTest {
  std::vector<std::string> reasons() {
    std::vector<std::string> reasons;
    const json::value recordings = call("recording.list").value();
    for (const json::value& recording : recordings.at("recordings").as_array())
      reasons.emplace_back(recording.at("reason").as_string());
    return reasons;
  }
  recording::Recording read(const std::string& name) {
    return recording::Recording::read(config::read_bytes(folder.path() / name)).value();
  }
  /// Devices that are lost are a fault of the cell.
  Wait fault() {
    co_await connected();
    robot.disconnect();
    co_await pass(2s);
    EXPECT_THAT(fault_of(*co_await ask("cell.status")), HasSubstr("robot"));
    co_await ask("cell.acknowledge");
  }
};

TEST_F(ARecordedCellService, SavesARecordingThatSaysWhatItIsOf) {
  load();
  play([this]() -> Wait { co_await connected(); });
  const json::value saved = call("recording.save").value();
  const std::string name{saved.at("name").as_string()};
  const recording::Header header = read(name).header();
  EXPECT_EQ(header.cell, config.name);
  EXPECT_EQ(header.reason, "asked for");
  EXPECT_EQ(header.robot.serial, "MOCK-0001");
  EXPECT_EQ(header.tracker.serial, "MOCK-0002");
  EXPECT_EQ(header.product, TRUEPOSE_VERSION);
  ASSERT_EQ(header.models.size(), 1U);
  EXPECT_EQ(header.models[0].id, "m1");
  EXPECT_EQ(header.models[0].sha256.size(), 64U);
  EXPECT_EQ(saved.at("bytes").to_number<std::size_t>(), std::filesystem::file_size(folder.path() / name));
  EXPECT_EQ(status().at_pointer("/recording/last").as_string(), name);
  EXPECT_THAT(reasons(), ElementsAre("asked for"));
}

TEST_F(ARecordedCellService, RecordsAFaultAndTheNextOneOnlyAMinuteLater) {
  play([this]() -> Wait {
    co_await fault();
    co_await fault();
    co_await pass(1min);
  });
  EXPECT_THAT(reasons(), ElementsAre(HasSubstr("E_CELL: robot"), HasSubstr("E_CELL: robot")));
  const json::value recordings = call("recording.list").value();
  const auto recording = [&](std::size_t i) {
    return read(std::string{recordings.at("recordings").at(i).at("name").as_string()});
  };
  std::vector<std::int64_t> record_times_ns;
  recording(0).for_each([&](const recording::Record& record) { record_times_ns.push_back(record.time_ns); });
  ASSERT_EQ(record_times_ns.size(), 2U) << "the newer one has both faults";
  constexpr std::int64_t kMinute_ns = 60'000'000'000;
  EXPECT_LT(record_times_ns[1] - record_times_ns[0], kMinute_ns);
  EXPECT_GE(recording(0).header().time_ns - recording(1).header().time_ns, kMinute_ns);
}

TEST_F(ARecordedCellService, KeepsTheRecordingJustMadeWhenTheClockWasSetBackAndRemovesTheOldest) {
  const auto save = [this] {
    const json::value saved = call("recording.save").value();
    const std::string written{saved.at("file").as_string()};
    EXPECT_EQ(saved.at("bytes").to_number<std::uintmax_t>(), std::filesystem::file_size(written)) << written;
    return std::string{saved.at("name").as_string()};
  };
  set_ahead = 24h;
  std::vector<std::string> newest_first;
  for (std::size_t i = 0; i < config.recording.max_files + 2; ++i) {
    newest_first.insert(newest_first.begin(), save());
    set_ahead -= 1h;
  }
  newest_first.resize(config.recording.max_files);
  std::vector<std::string> listed;
  const json::value recordings = call("recording.list").value();
  for (const json::value& recording : recordings.at("recordings").as_array())
    listed.emplace_back(recording.at("name").as_string());
  EXPECT_EQ(listed, newest_first);
  EXPECT_EQ(status().at_pointer("/recording/last").as_string(), newest_first.front());
}

TEST_F(ARecordedCellService, HandsOutNothingThatALinkLeadsTo) {
  const std::string name{call("recording.save")->at("name").as_string()};
  const std::filesystem::path secret = folder.write("secret", "of another"), at = config.recording.folder;
  std::filesystem::create_symlink(secret, at / "2026-11-28T10-00-00.000Z_9.pcapng");
  EXPECT_THAT(refused("recording.get", {{"name", "2026-11-28T10-00-00.000Z_9.pcapng"}}),
              HasSubstr("no such recording"));
  EXPECT_EQ(call("recording.list")->at("recordings").as_array().size(), 1U);
  std::filesystem::remove(at / name);
  std::filesystem::create_symlink(secret, at / name);
  EXPECT_FALSE(call("recording.get", {{"name", name}}));
}

TEST_F(ARecordedCellService, HandsARecordingOutPartByPart) {
  recorder.tell(recording::Wire::Tracker, recording::Kind::Received, std::string(60'000, 'x') + 'y');
  const std::string name{call("recording.save")->at("name").as_string()};
  std::string bytes;
  for (;;) {
    const json::value answer =
        call("recording.get", {{"name", name}, {"offset", static_cast<std::int64_t>(bytes.size())}}).value();
    const auto part = control::from_base64(std::string_view{answer.at("data").as_string()});
    ASSERT_TRUE(part);
    if (part->empty()) break;
    EXPECT_LE(part->size(), 32U << 10);
    bytes += *part;
  }
  EXPECT_EQ(bytes, config::read_bytes(folder.path() / name));
  EXPECT_EQ(refused("recording.get", {{"name", "../token"}}), "no such recording");
  EXPECT_THAT(refused("recording.get"), HasSubstr("name"));
}

TEST_F(ARecordedCellService, SaysWhichFolderCannotBeWrittenWhyAndWhatToDo) {
  std::filesystem::permissions(folder.path(),
                               std::filesystem::perms::owner_read | std::filesystem::perms::owner_exec);
  const Answer answer = [this] {
    const test::AsNobody nobody;
    return call("recording.save");
  }();
  std::filesystem::permissions(folder.path(), std::filesystem::perms::owner_all);
  ASSERT_FALSE(answer);
  EXPECT_EQ(answer.error().code, control::ErrorCode::Store);
  EXPECT_EQ(answer.error().message,
            "recording.folder: " + folder.path().string() +
                " cannot be written by this user (Permission denied): give a folder that can be");
}

TEST_F(ARecordedCellService, KeepsTheHeaderOfTheRingForWhoFindsIt) {
  load();
  play([this]() -> Wait {
    co_await connected();
    co_await pass(100ms);
  });
  const auto header = recording::Recording::read_header(config::read_bytes(folder.path() / "ring.header"));
  ASSERT_TRUE(header) << header.error();
  EXPECT_EQ(header->robot.serial, "MOCK-0001");
  EXPECT_EQ(header->models.size(), 1U);
}

/// The names of recordings in any text of a JSON value.
void gather_recordings(const json::value& value, std::set<std::string>& names) {
  if (const auto* const object = value.if_object()) {
    for (const auto& member : *object) gather_recordings(member.value(), names);
  } else if (const auto* const array = value.if_array()) {
    for (const json::value& each : *array) gather_recordings(each, names);
  } else if (value.is_string() && value.get_string().ends_with(".pcapng")) {
    names.insert(std::filesystem::path{std::string{value.get_string()}}.filename());
  }
}

TEST(TheExamplesOfTheSchema, NameRecordingsAsTheFolderThatTheyAreIn) {
  std::set<std::string> shown;
  gather_recordings(control::parse_json(control::openrpc_text()).value(), shown);
  ASSERT_FALSE(shown.empty());
  const TempFolder folder;
  const RecordingFolder recordings{{.folder = folder.path()}};
  for (const std::string& name : shown) {
    std::string date = name.substr(0, name.find('Z') + 1);
    std::replace(date.begin() + static_cast<std::ptrdiff_t>(date.find('T')), date.end(), '-', ':');
    const std::string made = recordings.file(date).filename();
    EXPECT_EQ(made, name) << "recordings of one folder, in the order of their dates";
    folder.write(made, "");
  }
}

TEST(Base64, IsReadAgainWhateverTheBytesAre) {
  std::string bytes;
  for (int i = 0; i < 300; ++i) {
    EXPECT_EQ(control::from_base64(control::base64(bytes)), bytes);
    bytes += static_cast<char>(i * 37);
  }
  EXPECT_EQ(control::base64("any"), "YW55");
  EXPECT_EQ(control::from_base64("!!!!"), std::nullopt);
}

}  // namespace
}  // namespace truepose::daemon
