#include "session/csv.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <linux/magic.h>
#include <sys/stat.h>
#include <sys/vfs.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <charconv>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <iterator>

#include "session/plain_text.h"

namespace sixdial::session {
namespace {

constexpr std::string_view kByteOrderMark = "\xEF\xBB\xBF";

struct TextPosition {
  int line = 1;
  int column = 1;
};

TextPosition place_of(std::string_view text, std::size_t offset) {
  TextPosition place;
  for (const char c : text.substr(0, offset)) {
    if (c == '\n') {
      ++place.line;
      place.column = 1;
    } else if ((static_cast<unsigned char>(c) & 0xC0U) != 0x80U) {
      ++place.column;
    }
  }
  return place;
}

/// Length of the UTF-8 character at the front of `text`; 0: none.
std::size_t utf8_length(std::string_view text) {
  const auto byte = [&](std::size_t i) {
    return i < text.size() ? static_cast<unsigned char>(text[i]) : 0U;
  };
  const auto continued = [&](std::size_t i) { return (byte(i) & 0xC0U) == 0x80U; };
  const unsigned first = byte(0);
  if (first < 0x80U) return 1;
  if (first >= 0xC2U && first < 0xE0U) return continued(1) ? 2 : 0;
  if (first >= 0xE0U && first < 0xF0U) {
    const bool overlong = first == 0xE0U && byte(1) < 0xA0U;
    const bool surrogate = first == 0xEDU && byte(1) >= 0xA0U;
    return !overlong && !surrogate && continued(1) && continued(2) ? 3 : 0;
  }
  if (first >= 0xF0U && first < 0xF5U) {
    const bool overlong = first == 0xF0U && byte(1) < 0x90U;
    const bool beyond = first == 0xF4U && byte(1) >= 0x90U;
    return !overlong && !beyond && continued(1) && continued(2) && continued(3) ? 4 : 0;
  }
  return 0;
}

/// "a pipe", "a device", ...; empty: a plain file.
std::string kind_of(mode_t mode) {
  if (S_ISREG(mode)) return "";
  if (S_ISDIR(mode)) return "a folder";
  if (S_ISFIFO(mode)) return "a pipe";
  return S_ISSOCK(mode) ? "a socket" : "a device";
}

/// Of an open file what it is instead of a plain one.
std::string special_kind(int fd) {
  constexpr off_t kLargest = off_t{4} << 30;  // bytes; 100,000 samples take 13 million
  struct stat about {};
  if (::fstat(fd, &about) != 0) return "";
  if (std::string kind = kind_of(about.st_mode); !kind.empty()) return kind;
  // Some of these never end, or wait for the kernel to say something.
  struct statfs on {};
  if (::fstatfs(fd, &on) == 0) {
    for (const long made_by_kernel :
         {PROC_SUPER_MAGIC, SYSFS_MAGIC, DEBUGFS_MAGIC, TRACEFS_MAGIC}) {
      if (static_cast<long>(on.f_type) == made_by_kernel) return "made by the kernel";
    }
  }
  return about.st_size > kLargest ? "larger than 4 GiB, as no session is" : "";
}

/// What a shell hands over: <(command), /dev/stdin.
bool is_a_shells(const std::string& path) {
  return path.starts_with("/dev/fd/") || path.starts_with("/proc/self/fd/") ||
         path == "/dev/stdin";
}

/// The file that a path means, through links, also to one that is not there yet.
std::string through_links(const std::string& path) {
  constexpr int kMostLinks = 40;  // as the kernel
  std::filesystem::path real = path;
  std::error_code ignored;
  for (int i = 0; i < kMostLinks && std::filesystem::is_symlink(real, ignored); ++i) {
    real = real.parent_path() / std::filesystem::read_symlink(real, ignored);
  }
  return real.string();
}

/// Line ends of old Macs: everything is one line.
void check_line_ends(std::string_view text, const std::string& file_name) {
  if (text.find('\n') != std::string_view::npos) return;
  const std::size_t end = text.find('\r');
  if (end == std::string_view::npos) return;
  if (text.find_first_not_of("\r \t", end) == std::string_view::npos) return;
  throw DataError(
      file_name, Mistake{
                     1, 1, "", "all is one line: its line ends are carriage returns (old Mac)",
                     "save it with line feeds (Unix or Windows)"});
}

void check_text(std::string_view text, const std::string& file_name) {
  check_is_plain(text, file_name);
  for (std::size_t i = 0; i < text.size();) {
    const std::size_t length = utf8_length(text.substr(i));
    if (length == 0 || text[i] == '\0') {
      const TextPosition place = place_of(text, i);
      throw DataError(
          file_name,
          Mistake{
              place.line, place.column, "",
              fmt::format(
                  "byte 0x{:02x} is not UTF-8 text", static_cast<unsigned char>(text[i])),
              "save the file as UTF-8"});
    }
    i += length;
  }
  check_line_ends(text, file_name);
}

std::size_t characters(std::string_view text) {
  std::size_t count = 0;
  for (const char c : text) count += (static_cast<unsigned char>(c) & 0xC0U) != 0x80U ? 1 : 0;
  return count;
}

/// Where the record that starts at `begin` ends: its '\n' or the end of the text. Line ends
/// inside closed quotes belong to the record.
std::size_t record_end(std::string_view text, std::size_t begin) {
  bool at_field_start = true;
  for (std::size_t i = begin; i < text.size(); ++i) {
    const char c = text[i];
    if (c == '\n') return i;
    if (c == '"' && at_field_start) {
      std::size_t j = i + 1;
      while (true) {
        j = text.find('"', j);
        if (j == std::string_view::npos) return std::min(text.find('\n', i), text.size());
        if (j + 1 < text.size() && text[j + 1] == '"') {
          j += 2;
          continue;
        }
        break;
      }
      i = j;
    }
    at_field_start = c == ',';
  }
  return text.size();
}

void split(CsvRow& row) {
  std::string_view text = row.text;
  if (text.ends_with('\r')) text.remove_suffix(1);
  if (row.line == 1 && text.starts_with(kByteOrderMark)) text.remove_prefix(3);
  std::size_t i = 0;
  int column = 1;
  while (true) {
    CsvField field;
    field.column = column;
    const std::size_t begin = i;
    if (i < text.size() && text[i] == '"') {
      bool closed = false;
      for (++i; i < text.size(); ++i) {
        if (text[i] != '"') {
          field.value += text[i];
        } else if (i + 1 < text.size() && text[i + 1] == '"') {
          field.value += text[i++];
        } else {
          closed = true;
          ++i;
          break;
        }
      }
      const bool trailing = closed && i < text.size() && text[i] != ',';
      if ((!closed || trailing) && !row.fault) {
        row.fault = Mistake{
            row.line, field.column, "",
            closed ? "text follows a closing quote" : "a quote is opened and never closed",
            "write a quote inside a quoted field twice"};
      }
    }
    const std::size_t comma = std::min(text.find(',', i), text.size());
    field.value += text.substr(i, comma - i);
    column += static_cast<int>(characters(text.substr(begin, comma - begin))) + 1;
    row.fields.push_back(std::move(field));
    if (comma == text.size()) return;
    i = comma + 1;
  }
}

std::string_view trimmed(std::string_view text) {
  while (!text.empty() && (text.front() == ' ' || text.front() == '\t')) text.remove_prefix(1);
  while (!text.empty() && (text.back() == ' ' || text.back() == '\t')) text.remove_suffix(1);
  return text;
}

std::string_view without_plus(std::string_view text) {
  if (text.size() > 1 && text[0] == '+' && text[1] != '-') text.remove_prefix(1);
  return text;
}

bool blank(std::string_view text) { return text.empty() || text == "\r"; }

}  // namespace

CsvTable read_csv(std::string_view text, const std::string& file_name) {
  check_text(text, file_name);
  const std::string_view content = text.starts_with(kByteOrderMark) ? text.substr(3) : text;
  if (content.find_first_not_of("\r\n \t") == std::string_view::npos) {
    throw DataError(
        file_name, Mistake{1, 1, "", "the file is empty", "the first line names the columns"});
  }
  CsvTable table;
  std::vector<CsvRow> rows;
  bool all_crlf = true;
  bool any_line_end = false;
  int line = 1;
  for (std::size_t begin = 0; begin < text.size();) {
    const std::size_t end = record_end(text, begin);
    CsvRow row;
    row.line = line;
    row.text = text.substr(begin, end - begin);
    line += 1 + static_cast<int>(std::count(row.text.begin(), row.text.end(), '\n'));
    if (end < text.size()) {
      any_line_end = true;
      all_crlf = all_crlf && row.text.ends_with('\r');
    }
    rows.push_back(std::move(row));
    begin = end + 1;
  }
  while (blank(rows.back().text)) rows.pop_back();
  table.line_end = any_line_end && all_crlf ? "\r\n" : "\n";
  if (table.line_end == "\r\n") {
    // A last row without any line end may still be complete: only a CR that ends a line goes.
    for (CsvRow& row : rows) {
      const bool ended = row.text.data() + row.text.size() != text.data() + text.size();
      if (ended) row.text.remove_suffix(1);
    }
  }
  const CsvRow& last = rows.back();
  table.end = std::string(
      text.substr(static_cast<std::size_t>(last.text.data() - text.data()) + last.text.size()));
  for (CsvRow& row : rows) split(row);
  table.header = std::move(rows.front());
  table.rows.assign(
      std::make_move_iterator(rows.begin() + 1), std::make_move_iterator(rows.end()));
  return table;
}

std::string csv_field(std::string_view value) {
  if (value.find_first_of(",\"\r\n") == std::string_view::npos) return std::string(value);
  std::string quoted = "\"";
  for (const char c : value) {
    if (c == '"') quoted += '"';
    quoted += c;
  }
  return quoted + '"';
}

ParsedNumber parse_number(std::string_view text) {
  const std::string_view number = without_plus(trimmed(text));
  if (number.empty()) return {0.0, NumberTrouble::kEmpty};
  double value = 0.0;
  const auto [end, error] =
      std::from_chars(number.data(), number.data() + number.size(), value);
  if (end != number.data() + number.size() || error == std::errc::invalid_argument) {
    return {0.0, NumberTrouble::kNotANumber};
  }
  if (error != std::errc{} || !std::isfinite(value)) return {0.0, NumberTrouble::kNotFinite};
  return {value, std::nullopt};
}

std::optional<int> parse_integer(std::string_view text) {
  const std::string_view number = without_plus(trimmed(text));
  int value = 0;
  const auto [end, error] =
      std::from_chars(number.data(), number.data() + number.size(), value);
  if (number.empty() || error != std::errc{} || end != number.data() + number.size()) {
    return std::nullopt;
  }
  return value;
}

std::string shown(std::string_view value) {
  constexpr std::size_t kMost = 40;
  if (value.size() <= kMost) return fmt::format("'{}'", value);
  std::size_t cut = kMost;  // not inside a character
  while ((static_cast<unsigned char>(value[cut]) & 0xC0U) == 0x80U) --cut;
  return fmt::format("'{}...'", value.substr(0, cut));
}

Mistake number_mistake(
    const CsvRow& row, const CsvField& field, const std::string& name, NumberTrouble trouble) {
  Mistake mistake{row.line, field.column, name, "", ""};
  switch (trouble) {
    case NumberTrouble::kEmpty:
      mistake.what = "the field is empty";
      mistake.hint = "this column needs a number in every row";
      break;
    case NumberTrouble::kNotANumber:
      mistake.what = shown(field.value) + " is not a number";
      mistake.hint = "write digits with a decimal point, such as 12.345";
      break;
    case NumberTrouble::kNotFinite:
      mistake.what = shown(field.value) + " is not a finite number";
      mistake.hint = "correct the value or leave the row out";
      break;
  }
  return mistake;
}

std::string decimal(double value, int least_digits) {
  constexpr int kMostDigits = 9;
  constexpr double kSame = 1e-10;  // far below any instrument, far above a double's last digit
  std::string text;
  for (int digits = least_digits; digits <= std::max(least_digits, kMostDigits); ++digits) {
    text = fmt::format("{:.{}f}", value, digits);
    if (std::abs(parse_number(text).value - value) <= kSame) break;
  }
  if (text.find_first_not_of("-0.") == std::string::npos && text[0] == '-') text.erase(0, 1);
  return text;
}

std::string as_utf8(std::string_view bytes) {
  std::string text;
  for (std::size_t i = 0; i < bytes.size();) {
    const std::size_t length = utf8_length(bytes.substr(i));
    if (length == 0 || bytes[i] == '\0') {
      text += '?';
      ++i;
    } else {
      text += bytes.substr(i, length);
      i += length;
    }
  }
  return text;
}

double rounded_decimal(double value, int digits) {
  return parse_number(fmt::format("{:.{}f}", value, digits)).value;
}

std::string read_file(const std::string& path) {
  const auto fail = [&](int code) {
    throw DataError(
        path, Mistake{
                  0, 0, "", fmt::format("cannot be read: {}", std::strerror(code)),
                  "check the path and the rights on it"});
  };
  // Without O_NONBLOCK the opening of a pipe waits for someone who writes into it.
  const int fd = ::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK);
  if (fd < 0) fail(errno);
  if (const std::string kind = special_kind(fd); !kind.empty() && !is_a_shells(path)) {
    ::close(fd);
    throw DataError(
        path,
        Mistake{
            0, 0, "", fmt::format("is {}, not a plain file", kind), "give the path of a file"});
  }
  ::fcntl(fd, F_SETFL, 0);
  std::string text;
  std::array<char, 65536> buffer;
  while (true) {
    const ssize_t count = ::read(fd, buffer.data(), buffer.size());
    if (count < 0 && errno == EINTR) continue;
    if (count < 0) {
      const int code = errno;
      ::close(fd);
      fail(code);
    }
    if (count == 0) break;
    text.append(buffer.data(), static_cast<std::size_t>(count));
  }
  ::close(fd);
  return text;
}

void write_file(const std::string& path, std::string_view text) {
  const auto fail = [&](const char* doing, int code) {
    throw DataError(
        path, Mistake{
                  0, 0, "", fmt::format("cannot be {}: {}", doing, std::strerror(code)),
                  "check the folder, the rights on it and the space left"});
  };
  const std::string real = through_links(path);
  struct stat before {};
  const bool there = ::stat(real.c_str(), &before) == 0;
  if (const std::string kind = there ? kind_of(before.st_mode) : ""; !kind.empty()) {
    throw DataError(
        path, Mistake{
                  0, 0, "", fmt::format("is {}, not a plain file", kind),
                  "choose another name; nothing was written"});
  }
  if (there && ::access(real.c_str(), W_OK) != 0) fail("written", errno);
  const std::string beside = fmt::format("{}.{}.part", real, ::getpid());
  const int fd = ::open(beside.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0644);
  if (fd < 0) fail("created", errno);
  if (there) (void)::fchmod(fd, before.st_mode & 07777);
  while (!text.empty()) {
    const ssize_t count = ::write(fd, text.data(), text.size());
    if (count < 0 && errno == EINTR) continue;
    if (count < 0) {
      const int code = errno;
      ::close(fd);
      ::unlink(beside.c_str());
      fail("written", code);
    }
    text.remove_prefix(static_cast<std::size_t>(count));
  }
  const bool synced = ::fsync(fd) == 0;
  const int sync_code = errno;
  ::close(fd);
  if (!synced || ::rename(beside.c_str(), real.c_str()) != 0) {
    const int code = synced ? errno : sync_code;
    ::unlink(beside.c_str());
    fail("written", code);
  }
}

}  // namespace sixdial::session
