#include "proto/rpc/methods.hpp"

#include <gtest/gtest.h>

#include <boost/json/parse.hpp>
#include <boost/json/serialize.hpp>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <string>

namespace truepose::rpc {
namespace {

namespace json = boost::json;

TEST(OpenRpc, IsWhatTheRecordsDescribe) {
  const std::string name = TRUEPOSE_SOURCE_DIR "/proto/control/openrpc.json";
  const auto read = [&name] {
    std::ifstream file{name};
    return json::parse(std::string{std::istreambuf_iterator<char>{file}, {}});
  };
  // Once more from its text, where a number has one way to be kept.
  const json::value described = json::parse(json::serialize(described_protocol(read().as_object())));
  if (std::getenv("TRUEPOSE_WRITE_SCHEMA")) std::ofstream{name} << described << "\n";
  EXPECT_EQ(read(), described)
      << "run this test with TRUEPOSE_WRITE_SCHEMA=1, then proto/control/write_tables.py";
}

}  // namespace
}  // namespace truepose::rpc
