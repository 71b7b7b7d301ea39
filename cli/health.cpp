#include "cli/health.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <system_error>

#include "acquisition/port_rights.h"
#include "acquisition/rig_scan.h"
#include "calibration/rig_spaces.h"
#include "calibration/space_fit.h"
#include "db/store.h"
#include "geometry/rig.h"
#include "geometry/tool.h"
#include "service/socket/client.h"

namespace sixdial::cli {
namespace {

constexpr std::uintmax_t kLeastRoom = 100'000'000;     // bytes; a session needs about 1 MB
constexpr std::uintmax_t kLittleRoom = 1'000'000'000;  // bytes
constexpr double kSlowSync_s = 0.25;
constexpr double kSameRobot_mm = 1e-6;

Check ok(std::string name, std::string what) {
  return {std::move(name), Health::kOk, std::move(what), "", service::ExitCode::kOk};
}
Check warning(std::string name, std::string what, std::string fix) {
  return {
      std::move(name), Health::kWarning, std::move(what), std::move(fix),
      service::ExitCode::kOk};
}
Check failed(std::string name, std::string what, std::string fix, service::ExitCode code) {
  return {std::move(name), Health::kFailed, std::move(what), std::move(fix), code};
}

std::string said(int error_number) { return std::generic_category().message(error_number); }

std::filesystem::path nearest_folder(std::filesystem::path path) {
  path = std::filesystem::absolute(path).parent_path();
  std::error_code ignored;
  while (!std::filesystem::is_directory(path, ignored) && path.has_relative_path()) {
    path = path.parent_path();
  }
  return path;
}

/// A write that is on the disk; its time [s], or why not.
tl::expected<double, std::string> synced_write(const std::filesystem::path& folder) {
  std::string name = (folder / ".sixdial-doctor-").string();
  name.append(6, 'X');  // mkstemp's
  const auto from = std::chrono::steady_clock::now();
  const int fd = ::mkstemp(name.data());
  if (fd < 0) return tl::unexpected(said(errno));
  const std::string block(4096, 's');
  const bool written = ::write(fd, block.data(), block.size()) == 4096 && ::fsync(fd) == 0;
  const int code = errno;
  ::close(fd);
  ::unlink(name.c_str());
  if (!written) return tl::unexpected(said(code));
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - from).count();
}

}  // namespace

std::vector<Check> check_ports(const std::filesystem::path& by_id) {
  std::vector<Check> checks;
  for (const acquisition::PortName& port : acquisition::serial_ports(by_id)) {
    const std::string what = fmt::format("{} ({})", port.name, port.device);
    if (::access(port.device.c_str(), R_OK | W_OK) != 0) {
      if (errno == ENOENT) continue;  // the kernel's driver has it, the machine does not
      checks.push_back(failed(
          "port", fmt::format("{}: {}", what, said(errno)),
          acquisition::rights_advice(port.device), service::ExitCode::kDevice));
    } else {
      checks.push_back(ok("port", what));
    }
  }
  if (checks.empty()) {
    checks.push_back(warning(
        "port", "no serial port is there",
        "plug the adapters in; a rig on Modbus TCP or a mock rig needs none"));
  }
  return checks;
}

Check check_socket(const std::filesystem::path& socket_path) {
  const std::string path = socket_path.string();
  std::error_code ignored;
  try {
    service::Client client(socket_path);
    const Json hello = client.call("hello");
    return ok(
        "socket",
        fmt::format(
            "{} {} answers on {}; you are {}", hello["service"].get<std::string>(),
            hello["version"].get<std::string>(), path, hello["operator"].get<std::string>()));
  } catch (const service::Error& error) {
    std::string fix = "start it: sixdiald, or systemctl start sixdiald.socket";
    if (std::filesystem::exists(socket_path, ignored)) {
      fix = ::access(path.c_str(), W_OK) != 0
                ? "sudo usermod -aG sixdial $USER, then log in again"
                : "the service that made it has ended: start it again, it takes the old socket "
                  "away by itself";
    }
    return failed("socket", error.what(), fix, service::ExitCode::kUnreachable);
  } catch (const service::RemoteError& error) {
    return failed(
        "socket", error.what(), error.error()["data"].value("hint", std::string()),
        service::ExitCode::kUnreachable);
  }
}

Check check_database(const std::filesystem::path& path) {
  std::error_code ignored;
  if (!std::filesystem::exists(path, ignored)) {
    const auto folder = nearest_folder(path);
    if (::access(folder.c_str(), W_OK | X_OK) != 0) {
      return failed(
          "database", fmt::format("{}: cannot be made: {}", path.string(), said(errno)),
          fmt::format("give the service's user rights on {}, or use --db", folder.string()),
          service::ExitCode::kFailed);
    }
    return ok("database", fmt::format("{}: none yet, the service makes it", path.string()));
  }
  try {
    db::Store store = db::Store::open_read_only(path.string());
    const std::vector<std::string> damage = store.check();
    if (!damage.empty()) {
      return failed(
          "database", fmt::format("{}: {}", path.string(), damage.front()),
          "keep the file as it is and go on with the last copy (sqlite3's .backup)",
          service::ExitCode::kFailed);
    }
    return ok(
        "database", fmt::format(
                        "{}: sound, schema {}, {} sessions", path.string(),
                        store.schema_version(), store.list_sessions().size()));
  } catch (const db::StoreError& error) {
    if (error.trouble == db::StoreTrouble::kTooOld) {
      return warning(
          "database", fmt::format("{}: {}", path.string(), error.problem), error.hint);
    }
    return failed(
        "database", fmt::format("{}: {}", path.string(), error.problem), error.hint,
        service::ExitCode::kFailed);
  }
}

Check check_disk(const std::filesystem::path& database) {
  const auto folder = nearest_folder(database);
  std::error_code error;
  const auto room = std::filesystem::space(folder, error);
  if (error) {
    return failed(
        "disk", fmt::format("{}: {}", folder.string(), error.message()), "choose another --db",
        service::ExitCode::kFailed);
  }
  const std::string free = fmt::format(
      "{:.1f} GB free in {}", static_cast<double>(room.available) * 1e-9, folder.string());
  if (room.available < kLeastRoom) {
    return failed(
        "disk", free, "make room: a full disk stops the collection",
        service::ExitCode::kFailed);
  }
  if (::access(folder.c_str(), W_OK) != 0 && std::filesystem::exists(database, error)) {
    return ok("disk", free + "; its files are the service's, so no write was tried");
  }
  const auto written_s = synced_write(folder);
  if (!written_s) {
    return failed(
        "disk", fmt::format("{}; a synced write fails: {}", free, written_s.error()),
        "check rights and the disk itself (dmesg, smartctl)", service::ExitCode::kFailed);
  }
  const std::string what =
      fmt::format("{}, a synced write takes {:.1f} ms", free, *written_s * 1e3);
  if (room.available < kLittleRoom) return warning("disk", what, "make room in time");
  if (*written_s > kSlowSync_s) {
    return warning("disk", what, "each sample waits for it: use a local disk");
  }
  return ok("disk", what);
}

Check check_known_answer() {
  const geometry::Rig rig = geometry::default_rig();
  const geometry::Tool tool(rig);
  const Eigen::VectorXd truth = geometry::table_2_robot();
  std::vector<simulation::Trial> seen;
  const int side = 5;
  for (int i = 0; i < side * side; ++i) {
    const int row = i / side;
    const Eigen::Vector2d target_mm(16.0 + 6.0 * (i % side), 30.0 + 9.0 * row);
    const auto q = tool.inverse(rig.robot.nominal, target_mm, rig.robot.working_mode);
    if (!q) continue;
    const auto p_WE = tool.position(truth, *q, rig.robot.assembly);
    if (!p_WE) continue;
    simulation::Trial trial;
    trial.sample = trial.point = static_cast<int>(seen.size());
    trial.q = *q;
    trial.assembly = rig.robot.assembly;
    trial.position_mm = *p_WE;
    seen.push_back(std::move(trial));
  }
  const auto count = std::ssize(seen);
  const auto from = std::chrono::steady_clock::now();
  const auto space = calibration::position_space(seen, rig);
  const auto fit = calibration::fit_space(space);
  const double took_s =
      std::chrono::duration<double>(std::chrono::steady_clock::now() - from).count();
  const double before_mm = calibration::position_rmse(space, space.nominal);
  const std::string what = fmt::format(
      "{} poses of a known robot: {:.3f} mm off before, {:.1e} mm after, in {:.0f} ms", count,
      before_mm, fit.rmse_mm, took_s * 1e3);
  if (count == side * side && fit.rmse_mm < kSameRobot_mm && before_mm > 0.1) {
    return ok("known answer", what);
  }
  return failed(
      "known answer", what, "this program was built or installed wrongly: install it again",
      service::ExitCode::kFailed);
}

}  // namespace sixdial::cli
