#pragma once

#include <sqlite3.h>

#include <filesystem>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

namespace truepose {

/// What a query finds in a store's file, as anyone with SQLite would read it.
inline std::vector<std::vector<std::string>> sqlite_rows(const std::filesystem::path& file,
                                                         const char* query) {
  sqlite3* opened = nullptr;
  sqlite3_open_v2(file.c_str(), &opened, SQLITE_OPEN_READWRITE, nullptr);
  const std::unique_ptr<sqlite3, decltype(&sqlite3_close)> database{opened, &sqlite3_close};
  sqlite3_stmt* prepared = nullptr;
  if (sqlite3_prepare_v2(opened, query, -1, &prepared, nullptr) != SQLITE_OK)
    throw std::runtime_error{sqlite3_errmsg(opened)};
  const std::unique_ptr<sqlite3_stmt, decltype(&sqlite3_finalize)> statement{prepared, &sqlite3_finalize};
  std::vector<std::vector<std::string>> rows;
  while (sqlite3_step(prepared) == SQLITE_ROW) {
    std::vector<std::string>& row = rows.emplace_back();
    for (int column = 0; column < sqlite3_column_count(prepared); ++column)
      row.emplace_back(reinterpret_cast<const char*>(sqlite3_column_text(prepared, column)));
  }
  return rows;
}

}  // namespace truepose
