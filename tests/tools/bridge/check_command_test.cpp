#include <gmock/gmock.h>

#include <boost/json/parse.hpp>
#include <string>

#include "tests/simulator_process.hpp"

namespace truepose::sim {
namespace {

using testing::HasSubstr;

TEST(BridgeCheckCommand, TellsWhatTheSimulatedBridgeKeepsAndEndsOne) {
  const TempFolder folder;
  const auto ready = folder.path() / "ready.json";
  SimulatorProcess simulator{folder,
                             {"--scenario", TRUEPOSE_SOURCE_DIR "/config/scenarios/demo.yaml", "--rsi-target",
                              "127.0.0.1:9", "--bridge-port", "0", "--speedup", "20", "--ready-file", ready}};
  const std::string ports = simulator.ready(ready);
  ASSERT_FALSE(ports.empty()) << simulator.errors();
  const auto port = boost::json::parse(ports).at("bridge_port").as_int64();
  const std::string where = "127.0.0.1:" + std::to_string(port);
  const Finished kept = run_program("truepose", {"bridge-check", where});
  EXPECT_EQ(kept.exit_code, 0) << kept.out << kept.err;
  EXPECT_THAT(kept.out, HasSubstr("hello is answered"));
  EXPECT_THAT(kept.out, HasSubstr("give --at X,Y,Z"));
  const Finished nothing_there =
      run_program("truepose", {"bridge-check", where, "--at", "100,100,5000", "--search", "5"});
  EXPECT_EQ(nothing_there.exit_code, 1) << nothing_there.out;
  EXPECT_THAT(nothing_there.out, HasSubstr("a reflector is found where it stands"));
  EXPECT_THAT(nothing_there.out, HasSubstr("next: see that one stands there"));
  simulator.terminate();
  simulator.wait();
  EXPECT_EQ(run_program("truepose", {"bridge-check", where}).exit_code, 3);
  EXPECT_EQ(run_program("truepose", {"bridge-check", "nowhere"}).exit_code, 2);
}

}  // namespace
}  // namespace truepose::sim
