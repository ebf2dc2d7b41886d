// Lines of the control port. A stream gives the same ones however it is cut; a request that is accepted can
// be written and read.
#include <boost/json/object.hpp>
#include <boost/json/value.hpp>
#include <string>
#include <vector>

#include "proto/control/json_text.hpp"
#include "proto/control/line_splitter.hpp"
#include "proto/control/request.hpp"
#include "proto/rpc/campaign.hpp"
#include "proto/rpc/events.hpp"
#include "proto/rpc/params.hpp"
#include "proto/rpc/targets.hpp"
#include "tests/fuzz/pieces.hpp"
#include "tests/fuzz/target.hpp"

namespace truepose::fuzz {
namespace {

constexpr std::size_t kLongestLine = 256;  // short, so that lines that are too long come

/// The lines of a stream, up to the first that is too long.
std::vector<std::string> lines(const std::vector<std::string_view>& pieces) {
  control::LineSplitter splitter{kLongestLine};
  std::vector<std::string> lines;
  for (const std::string_view piece : pieces) {
    splitter.push(piece);
    while (auto line = splitter.next()) lines.push_back(std::move(*line));
    if (splitter.overflowed()) break;
  }
  return lines;
}

/// Reads parameters as those of one method.
template <rpc::Request R>
void read_params(const boost::json::object& params) {
  const auto request = rpc::read_params<R>(params);
  if (request) return;
  const control::RpcError& error = request.error();
  expect(error.code == control::ErrorCode::InvalidParams && !error.message.empty(), "a refusal says why");
  expect(control::parse_json(control::json_text(boost::json::value(error.message))).has_value(),
         "a refusal can be sent: " + error.message);
}

void read_request(const std::string& line) {
  const auto request = control::decode_request(line);
  if (!request) {
    const std::string answer = control::encode_error(request.error().id, request.error().error);
    expect(control::decode_server_line(answer).has_value(), "a refusal can be read: " + answer);
    return;
  }
  const std::string text = control::encode_request(request->id, request->method, request->params);
  const auto again = control::decode_request(text);
  expect(again && again->id == request->id && again->method == request->method &&
             control::json_text(again->params) == control::json_text(request->params),
         "what is written is read again: " + text);
  read_params<rpc::CampaignStart>(request->params);
  read_params<rpc::EventsSubscribe>(request->params);
  read_params<rpc::TargetsCompensate>(request->params);
}

}  // namespace

void control(std::string_view input) {
  const std::vector<std::string> whole = lines({input});
  expect(lines(pieces_of(input)) == whole && lines(bytes_of(input)) == whole,
         "a stream gives the same lines however it is cut");
  for (const std::string& line : whole) {
    read_request(line);
    if (const auto message = control::decode_server_line(line); !message)
      expect(!message.error().empty(), "a refusal says why");
  }
}

}  // namespace truepose::fuzz
