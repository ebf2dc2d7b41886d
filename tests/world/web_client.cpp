#include "tests/world/web_client.hpp"

#include <cstdlib>
#include <memory>
#include <sstream>
#include <vector>

namespace truepose::world {

namespace asio = boost::asio;

namespace {

/// The whole answer, until the server closes.
asio::awaitable<std::string> get(World& world, std::string path) {
  const std::unique_ptr<net::Stream> stream = world.network.streams()(world.outside.get_executor());
  const auto failed = co_await stream->connect("127.0.0.1", World::kWebPort);
  if (failed) co_return std::string{};
  const std::string request = "GET " + path + " HTTP/1.1\r\nHost: 127.0.0.1\r\nConnection: close\r\n\r\n";
  co_await stream->write(request);
  std::string answer;
  // All in one piece: how long it is depends on the real process, which the world must not see.
  std::vector<char> buffer(std::size_t{1} << 20U);
  for (;;) {
    const auto [error, size] = co_await stream->read(buffer);
    if (error || size == 0) break;
    answer.append(buffer.data(), size);
  }
  co_return answer;
}

}  // namespace

asio::awaitable<std::map<std::string, double>> metrics(World& world) {
  const std::string answer = co_await get(world, "/metrics");
  std::map<std::string, double> numbers;
  std::istringstream lines{answer};
  for (std::string line; std::getline(lines, line);) {
    const std::size_t space = line.rfind(' ');
    if (line.starts_with("truepose_") && space != std::string::npos)
      numbers[line.substr(0, space)] = std::strtod(line.c_str() + space, nullptr);
  }
  co_return numbers;
}

}  // namespace truepose::world
