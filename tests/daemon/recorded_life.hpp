#pragma once

#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "config/model_file.hpp"
#include "config/text_file.hpp"
#include "daemon/recorder/recorder.hpp"
#include "daemon/recorder/stream_settings.hpp"
#include "drivers/mock/virtual_clock.hpp"
#include "tests/daemon/altered_recording.hpp"
#include "tests/daemon/stream_rig.hpp"
#include "tests/temp_folder.hpp"

namespace truepose::daemon {

/// The rig's controller and a stream that is recorded. Its models 1 and 2 are those of real_arm(1) and (2).
class RecordedLife {
 public:
  explicit RecordedLife(std::size_t ring_bytes = 8 * Ring::kLeastBytes)
      : recorder{Ring::in_process(ring_bytes), clock_}, stream_{*rig.cycle, *memory_, recorder.exchanges()} {
    rig.in_front = &stream_;
  }

  void use_model(int number) { rig.cycle->use_model(real_arm(number), static_cast<std::uint64_t>(number)); }
  /// A cycle of the controller, which is written at once.
  void tick(const Fate& fate = {}) {
    rig.tick(fate);
    recorder.drain();
  }
  void ticks(int count) {
    for (int i = 0; i < count; ++i) tick();
  }

  static recording::Header header() {
    const auto yaml = [](const RobotModel& robot) {
      return config::model_yaml(
          {.name = robot.name, .cell = {.robot = robot, .base = {}, .reflectors = {{.name = "1"}}}});
    };
    std::string ethernet =
        config::read_text_file(TRUEPOSE_SOURCE_DIR "/config/kuka/rsi/truepose_rsi_ethernet.xml");
    const std::string rist = R"(<ELEMENT TAG="DEF_RIst" TYPE="DOUBLE" INDX="INTERNAL"/>)";
    ethernet.erase(ethernet.find(rist), rist.size());  // as ethernet_config()
    return {.ethernet_xml = std::move(ethernet),
            .nominal_yaml = yaml(nominal_arm()),
            .stream = settings_of(stream_options()),
            .models = {{1, "m1", "", yaml(real_arm(1))}, {2, "m2", "", yaml(real_arm(2))}}};
  }
  /// @param alter  a record on its way into the recording
  recording::Recording saved(const std::function<void(recording::Record&)>& alter = {},
                             const recording::Header& header = RecordedLife::header()) {
    const auto file = folder_.path() / "life";
    EXPECT_TRUE(recorder.save(header, file));
    auto recording = recording::Recording::read(config::read_bytes(file)).value();
    if (!alter) return recording;
    std::vector<recording::Record> records = records_of(recording);
    for (recording::Record& record : records) alter(record);
    return recording_of(header, records);
  }

 private:
  TempFolder folder_;
  drivers::VirtualClock clock_;
  std::unique_ptr<StreamMemory> memory_ = StreamMemory::in_process();

 public:
  Recorder recorder;
  StreamRig rig{stream_options(), ethernet_config(), memory_.get()};

 private:
  RecordedStream stream_;
};

}  // namespace truepose::daemon
