#include "tests/world/model_edit.hpp"

#include <array>
#include <cstddef>
#include <cstdlib>
#include <regex>
#include <string>
#include <vector>

#include "config/sealed_text.hpp"
#include "daemon/store/sqlite.hpp"
#include "proto/text/digest.hpp"

namespace truepose::world {

namespace {

namespace sqlite = daemon::sqlite;

enum class Edit { Digit, DigitAndRow, LinkAndAllHashes };

std::string other_digit(std::string text, Random& random) {
  std::vector<std::size_t> digits;
  for (std::size_t at = 0; at < text.size(); ++at)
    if (text[at] >= '0' && text[at] <= '9') digits.push_back(at);
  const auto which = static_cast<std::size_t>(random.uniform() * static_cast<double>(digits.size()));
  char& digit = text[digits.at(which)];
  digit = digit == '9' ? '0' : static_cast<char>(digit + 1);
  return text;
}

/// The upper arm's, which is 1150 mm long, and the seal of the text.
std::string longer_link(const std::string& text, Random& random) {
  static const std::regex kUpperArm{R"(\{a: (11\d\d[.\d]*))"};
  std::smatch length;
  const std::string body = text.substr(0, text.rfind("sha256:"));
  if (!std::regex_search(body, length, kUpperArm)) return text;
  const double longer_mm = std::strtod(length[1].str().c_str(), nullptr) + random.uniform(1, 20);
  return config::sealed(length.prefix().str() + "{a: " + std::to_string(longer_mm) + length.suffix().str());
}

}  // namespace

boost::asio::awaitable<void> edit_model(Cell& cell, Random& random) {
  co_await cell.end_of_daemon();
  const auto database = sqlite::Database::open("cell.sqlite");
  if (!database) co_return;
  sqlite::Statement active = (*database)->prepare("SELECT id, yaml, sha256 FROM model WHERE active=1");
  const auto found = active.step();
  if (!found || !*found) co_return;
  const std::string id = active.text(0), text = active.document(1);
  if (!active.run()) co_return;
  constexpr std::array kEdits{Edit::Digit, Edit::DigitAndRow, Edit::LinkAndAllHashes};
  const Edit edit = kEdits.at(static_cast<std::size_t>(random.uniform() * kEdits.size()));
  const std::string edited =
      edit == Edit::LinkAndAllHashes ? longer_link(text, random) : other_digit(text, random);
  sqlite::Statement update =
      (*database)->prepare(edit == Edit::Digit ? "UPDATE model SET yaml=? WHERE id=?"
                                               : "UPDATE model SET yaml=?, sha256=? WHERE id=?");
  update.bind(edited);
  if (edit != Edit::Digit) update.bind(text::sha256_hex(edited));
  update.bind(id);
  if (update.run()) cell.edited_models.insert(id);
}

}  // namespace truepose::world
