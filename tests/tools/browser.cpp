#include "tests/tools/browser.hpp"

#include <gtest/gtest.h>

#include <sstream>
#include <string_view>

#include "tests/process.hpp"
#include "tests/temp_folder.hpp"

namespace truepose {

namespace {

// The console says nothing of files on the disk that are not there.
constexpr std::string_view kWatch = R"html(<head><script>
addEventListener("error", function (event) {
  if (event.target !== window) console.error("cannot be loaded: " + (event.target.src || event.target.href));
}, true);
</script>)html";

}  // namespace

Browsed browse(std::string html) {
  const TempFolder folder;
  html.replace(html.find("<head>"), 6, kWatch);
  const std::filesystem::path page = folder.write("page.html", html);
  // Tests run as root where the machine is a container, and there Chromium has no sandbox.
  Process chromium{folder.path(),
                   "/usr/bin/chromium",
                   {"--headless=new", "--no-sandbox", "--disable-gpu", "--no-first-run",
                    "--user-data-dir=" + (folder.path() / "profile").string(), "--virtual-time-budget=10000",
                    "--enable-logging=stderr", "--dump-dom", "file://" + page.string()},
                   {"HOME=" + folder.path().string()}};
  EXPECT_EQ(chromium.wait(), 0) << chromium.errors();
  Browsed browsed{.dom = chromium.output(), .console = {}};
  std::istringstream log{chromium.errors()};
  for (std::string line; std::getline(log, line);) {
    if (line.find("CONSOLE") != std::string::npos) browsed.console.push_back(line);
  }
  return browsed;
}

}  // namespace truepose
