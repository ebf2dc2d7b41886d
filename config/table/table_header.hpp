#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "config/table/column_name.hpp"
#include "config/table/csv_reader.hpp"
#include "config/table/table_reading.hpp"

namespace truepose::config {

/// A header, and how many records there are up to and with it; no fields: none was found.
struct HeaderPlace {
  CsvRow row;
  std::size_t end = 0;
};

/// The record, among the first ones, that names the most columns of the form. A comment may be it, as numpy
/// writes it.
HeaderPlace header_in(const std::vector<CsvRow>& records, const std::string& file, const TableForm& form,
                      const TableReading& reading);

/// The numbers of the columns in place of names, where the user has chosen by them.
HeaderPlace header_of_numbers(const std::vector<CsvRow>& records, const TableReading& reading);

/// The names above KRL aggregates, which have the names of their members in them; numbers where there are
/// none.
HeaderPlace header_of_krl(const std::vector<CsvRow>& records);
bool has_krl_cells(const std::vector<CsvRow>& records);

/// Throws ConfigError where the names of the columns stand below each other, in front of their numbers.
void refuse_rows_of_columns(const std::vector<CsvRow>& records, const std::string& file,
                            const TableForm& form, const TableReading& reading);

/// Throws ConfigError: that no column is known, or that there is no header.
/// @param encoding  that was taken for the file's; empty: UTF-8
[[noreturn]] void refuse_header(const std::vector<CsvRow>& records, const std::string& file,
                                const TableForm& form, const std::string& encoding);

/// What the columns are, by the user's choice or by their names.
std::vector<ColumnName> meanings_of(const std::vector<std::string>& headers, const TableReading& reading);

/// Whether a header has our names alone, and a fault that the reader of our own form names.
bool has_faulty_own_names(const std::vector<std::string>& headers, const TableForm& form);

/// Whether a record has numbers and empty fields alone.
bool is_of_numbers(const CsvRow& row);
bool is_empty(const CsvRow& row);

/// Names in quotes, the first dozen.
std::string list_of(const std::vector<std::string>& names);

/// How --columns says what columns have these names: "q1=NAME,q2=NAME,..", by number "q1=1,q2=2,..".
std::string choice_of(const std::vector<std::string>& names, bool by_number);

}  // namespace truepose::config
