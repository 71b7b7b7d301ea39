// sixdial-mock-rig: a rig that is not there. Prints one line of JSON with its ports when ready,
// serves until SIGINT or SIGTERM. With --bundle it writes a whole measured session instead.
#include <fmt/format.h>
#include <pthread.h>

#include <CLI/CLI.hpp>
#include <csignal>
#include <cstdio>
#include <exception>
#include <fstream>
#include <iostream>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "cli/manual.h"
#include "cli/shared_options.h"
#include "geometry/rig.h"
#include "geometry/units.h"
#include "mock_devices/arm_in_sockets.h"
#include "mock_devices/iso_time.h"
#include "mock_devices/mock_arm.h"
#include "mock_devices/mock_rig.h"
#include "mock_devices/session_generator.h"
#include "mock_devices/workshop.h"
#include "session/csv.h"
#include "session/plan.h"
#include "session/plan_sheet.h"
#include "session/rig_file.h"

namespace {

using namespace sixdial;

constexpr const char* kRegisters = "modbus";

struct Arguments {
  mock_devices::MockRigOptions rig;
  std::string rig_file;
  std::string write_rig;
  std::string robot = "table2";
  std::string controller = kRegisters;
  std::optional<double> clamp_deg;
  std::vector<std::string> hide;
  std::optional<std::uint64_t> hide_seed;
  std::string hide_pool = "catalogue";
  std::string reveal_file;
  bool workshop = false;
  geometry::Rig file;  // what people wrote down of the rig
  std::string bundle;
  std::vector<int> points{100, 50};
  int joints = 6;
  std::string fill;  // a folder of sixdial plan sockets --bundle
};
constexpr const char* kArm = "serial";
constexpr double kArmNoise_mm = 0.02;  // of a wire's reading

void write_text(const std::string& file, const std::string& text, const char* option) {
  std::ofstream out(file);
  out << text;
  if (!out.flush()) throw std::runtime_error(fmt::format("{}: cannot write {}", option, file));
}

mock_devices::Pool pool_of(const std::string& name) {
  if (name == "outside") return mock_devices::Pool::kOutside;
  return name == "all" ? mock_devices::Pool::kAll : mock_devices::Pool::kCatalogue;
}

/// A rig as rigs are: all that `--workshop` means is drawn from the seed; what else was asked
/// for stays.
void make_workshop(mock_devices::World& world, int samples) {
  mock_devices::Workshop drawn =
      mock_devices::drawn_workshop(world.rig, world.seed, {}, samples);
  world.rig = std::move(drawn.world.rig);
  world.effects = std::move(drawn.world.effects);
  world.dials.curve_mm = drawn.world.dials.curve_mm;
  world.warm_up = drawn.world.warm_up;
}

void make_world(Arguments& arguments) {
  mock_devices::World& world = arguments.rig.world;
  if (!arguments.rig_file.empty()) world.rig = session::read_rig_file(arguments.rig_file);
  arguments.file = world.rig;
  if (arguments.workshop) {
    make_workshop(world, std::max(1, arguments.points[0] + arguments.points[1]));
  }
  const mock_devices::TrueRobot drawn = mock_devices::drawn_robot(world.rig, world.seed);
  if (arguments.robot == "drawn") {
    world.robot.parameters = drawn.parameters;
  } else if (arguments.robot == "nominal") {
    world.robot.parameters = world.rig.robot.nominal;
  } else {
    world.robot.parameters = geometry::table_2_robot();
  }
  world.robot.clamp_rad =
      arguments.clamp_deg ? *arguments.clamp_deg * geometry::kRadPerDeg : drawn.clamp_rad;
  std::uint64_t seed = world.seed;
  for (const std::string& text : arguments.hide) {
    world.effects.push_back(mock_devices::parse_effect(world.rig, text, seed++));
  }
  if (arguments.hide_seed) {
    world.effects.push_back(mock_devices::draw_effect(
        world.rig, *arguments.hide_seed, pool_of(arguments.hide_pool)));
  }
  if (!arguments.reveal_file.empty()) {
    write_text(arguments.reveal_file, mock_devices::answer_json(world), "--reveal");
  }
}

void add_controller(CLI::App& app, Arguments& arguments) {
  std::vector<std::string> names{kRegisters};
  for (const std::string_view each : mock_devices::served_controllers()) {
    names.emplace_back(each);
  }
  app.add_option(
         "--robot-controller", arguments.controller,
         "What moves the robot: registers on Modbus TCP, a firmware that takes G-code on a TCP "
         "port (grbl, marlin, klipper), Klipper's API socket, or LinuxCNC's remote")
      ->check(CLI::IsMember(names))
      ->capture_default_str();
  app.add_option(
      "--robot-link", arguments.rig.robot_link,
      "Of klipper-socket: its socket, else one in the temporary folder; of grbl, marlin and "
      "klipper: link to a pseudo-terminal beside the port");
}

void add_options(CLI::App& app, Arguments& arguments) {
  mock_devices::MockRigOptions& rig = arguments.rig;
  mock_devices::World& world = rig.world;
  app.add_option("--rig", arguments.rig_file, "rig.toml: nominal robot, cuboid and dials")
      ->check(CLI::ExistingFile);
  app.add_option("--address", rig.address, "Loopback address to listen on")
      ->capture_default_str();
  app.add_option("--dial-port", rig.dial_port, "Modbus TCP port of the six dials, 0: any free");
  app.add_option("--robot-port", rig.robot_port, "TCP port of the robot, 0: any free");
  add_controller(app, arguments);
  app.add_option("--pty-dir", rig.pty_directory, "Folder for links to the serial dials");
  app.add_option("--dialects", rig.dialects, "Serial dialects: mux10 sylvac mahr mw modbus_rtu")
      ->delimiter(',');
  app.add_option("--rtu-baud", rig.rtu_baud, "Baud of modbus_rtu")
      ->check(CLI::Range(1200, 921600))
      ->capture_default_str();
  app.add_option("--speed", rig.clock_speed, "Mock seconds a second")->capture_default_str();
  app.add_option("--start-time", rig.start_time, "Mock UTC at the start")
      ->capture_default_str();
  cli::add_seed(app, world.seed, "Seed of everything that is drawn");
  app.add_option(
         "--robot", arguments.robot,
         "The true robot: a five-bar, or an arm of joints in series under draw wires (serial), "
         "drawn from the seed")
      ->check(CLI::IsMember({"table2", "drawn", "nominal", kArm}))
      ->capture_default_str();
  app.add_option("--joints", arguments.joints, "Of an arm")
      ->check(CLI::Range(3, 8))
      ->capture_default_str();
  app.add_option("--clamp", arguments.clamp_deg, "Clamp angle of the cuboid [deg], else drawn");
  app.add_option("--noise", world.dials.noise_sd_mm, "Noise of a reading, sd [mm]")
      ->capture_default_str();
  app.add_option("--quantum", world.dials.quantum_mm, "Resolution [mm], 0: none")
      ->capture_default_str();
  app.add_option("--hysteresis", world.dials.hysteresis_mm, "Hysteresis of each dial [mm]")
      ->capture_default_str();
  app.add_option("--curve", world.dials.curve_mm, "Bound of each dial's error curve [mm]")
      ->capture_default_str();
  app.add_option("--warm-up", world.warm_up.rise_c, "Rise of the temperature [K]")
      ->capture_default_str();
  app.add_option("--warp", world.warp.amplitude_mm, "Smooth non-kinematic XY error, rms [mm]")
      ->capture_default_str();
  app.add_option("--warp-wavelength", world.warp.wavelength_mm, "Its wavelength [mm]")
      ->capture_default_str();
  app.add_option("--hide", arguments.hide, "Hidden effect, cause[:where[:amplitude]]");
  app.add_option("--hide-seed", arguments.hide_seed, "Hide an effect drawn from this seed")
      ->check(cli::seed_number());
  app.add_option("--hide-pool", arguments.hide_pool, "What --hide-seed draws from")
      ->check(CLI::IsMember({"catalogue", "outside", "all"}))
      ->capture_default_str();
  app.add_option(
      "--write-rig", arguments.write_rig,
      "When ready, write a rig file here that leads to this rig's ports");
  app.add_flag(
      "--workshop", arguments.workshop,
      "A rig as rigs are, drawn from the seed: dials that stand a little elsewhere than the "
      "rig "
      "file says, with error curves; gears that run out; links and base that move with the "
      "day");
  app.add_option("--reveal", arguments.reveal_file, "Write what is hidden to this JSON file");
  CLI::Option* bundle = app.add_option(
      "--bundle", arguments.bundle,
      "Write a session measured on this rig (session.csv, rig.toml) to this folder, and end");
  app.add_option(
      "--fill", arguments.fill,
      "A folder that sixdial plan sockets --bundle made: fill in its session.csv as a "
      "simulated "
      "arm with lengths and zeros a little off its rig.toml, led from socket to socket, and "
      "end");
  app.add_option("--points", arguments.points, "Of the bundle: points of G1 and of G2")
      ->delimiter(',')
      ->expected(2)
      ->check(CLI::Range(0, 100000))
      ->needs(bundle)
      ->capture_default_str();
}

mock_devices::ArmWorld arm_world(const Arguments& arguments) {
  const std::uint64_t seed = arguments.rig.world.seed;
  mock_devices::ArmWorld world = mock_devices::drawn_arm(seed, arguments.joints);
  world.noise_mm = kArmNoise_mm;
  world.warm_up_c = arguments.rig.world.warm_up.rise_c;
  std::uint64_t next = seed;
  for (const std::string& text : arguments.hide) {
    world.effects.push_back(mock_devices::parse_arm_effect(world, text, next++));
  }
  if (arguments.hide_seed) {
    world.effects.push_back(mock_devices::draw_arm_effect(world, *arguments.hide_seed));
  }
  if (!arguments.reveal_file.empty()) {
    write_text(arguments.reveal_file, mock_devices::arm_answer_json(world), "--reveal");
  }
  return world;
}

/// session.csv of a plan of sockets, as an arm that is not quite as its rig file says reads its
/// joints when somebody leads it there.
void fill_sockets(const std::string& folder, std::uint64_t seed) {
  const geometry::Rig rig = session::read_rig_file(folder + "/rig.toml");
  session::Plan plan = session::read_plan(folder + "/plan.csv", rig);
  std::vector<mock_devices::SocketVisit> visits;
  for (const session::PlanPoint& point : plan.points) visits.push_back({point.socket, point.q});
  const auto read = mock_devices::seated(mock_devices::arm_of_rig(rig, seed), rig, visits);
  for (std::size_t i = 0; i < read.size(); ++i) plan.points[i].q = read[i];
  session::write_file(folder + "/session.csv", session::filled_session(plan, rig));
}

/// Random poses, each joint arriving from either side; as a careful operator would bring it.
void write_session(const Arguments& arguments) {
  const mock_devices::World& world = arguments.rig.world;
  mock_devices::write_bundle(
      arguments.bundle,
      mock_devices::generate_session(
          world, mock_devices::random_plan(
                     arguments.file, world.seed, arguments.points[0], arguments.points[1])),
      arguments.file, arguments.rig.start_time);
}

/// Where the robot's controller is: its port, 0 where it has a socket file, and what rig.toml
/// says of it.
template <typename Mock>
void add_robot(const Mock& mock, nlohmann::ordered_json& line) {
  if constexpr (requires { mock.ports(); }) {
    line["robot_port"] = mock.ports().robot;
  } else {
    line["robot_port"] = mock.robot_port();
  }
  line["robot_connection"] = mock.robot_connection();
  const std::string serial = mock.robot_serial_connection();
  if (!serial.empty()) line["robot_serial_connection"] = serial;
}

std::string ready_line(const mock_devices::MockRig& rig, const Arguments& arguments) {
  const mock_devices::MockPorts ports = rig.ports();
  nlohmann::ordered_json line;
  line["ready"] = true;
  line["address"] = arguments.rig.address;
  line["dial_port"] = ports.dials;
  add_robot(rig, line);
  line["serial"] = nlohmann::ordered_json::object();
  for (const auto& [name, path] : ports.serial) line["serial"][name] = path.string();
  line["speed"] = arguments.rig.clock_speed;
  line["start_time"] = arguments.rig.start_time;
  line["now"] = mock_devices::iso8601(rig.utc_ms());
  line["seed"] = arguments.rig.world.seed;
  return line.dump();
}

std::string ready_line(const mock_devices::MockArm& arm, const Arguments& arguments) {
  nlohmann::ordered_json line;
  line["ready"] = true;
  line["address"] = arguments.rig.address;
  line["dial_port"] = arm.dial_port();
  add_robot(arm, line);
  line["speed"] = arguments.rig.clock_speed;
  line["start_time"] = arguments.rig.start_time;
  line["now"] = mock_devices::iso8601(arm.utc_ms());
  line["seed"] = arguments.rig.world.seed;
  return line.dump();
}

/// What the file says of the rig, with the connections that are open.
geometry::Rig as_written_down(geometry::Rig file, const geometry::Rig& connected) {
  file.robot.connection = connected.robot.connection;
  for (std::size_t i = 0; i < file.dials.size(); ++i) {
    file.dials[i].connection = connected.dials[i].connection;
  }
  return file;
}

/// The exit code after output: a full disk or a closed pipe is no success.
int printed() {
  if (std::fflush(stdout) == 0 && std::ferror(stdout) == 0) return 0;
  fmt::print(stderr, "sixdial-mock-rig: the output could not be written whole\n");
  return 1;
}

/// Until a signal; the exit code.
int wait_for_signal(const sigset_t& signals) {
  if (printed() != 0) return 1;
  int received = 0;
  sigwait(&signals, &received);
  return 0;
}

/// An arm instead of the five-bar: a session written, or its ports served.
int run_arm(const Arguments& arguments, const sigset_t& signals) {
  const mock_devices::ArmWorld world = arm_world(arguments);
  if (!arguments.bundle.empty()) {
    mock_devices::write_arm_bundle(
        arguments.bundle,
        mock_devices::measure_arm(world, arguments.points[0], arguments.points[1]), world);
    return 0;
  }
  mock_devices::MockArm arm(
      {.world = world,
       .rows = std::max(1, arguments.points[0] + arguments.points[1]),
       .clock_speed = arguments.rig.clock_speed,
       .start_time = arguments.rig.start_time,
       .address = arguments.rig.address,
       .dial_port = arguments.rig.dial_port,
       .robot_port = arguments.rig.robot_port,
       .robot_controller = arguments.rig.robot_controller,
       .robot_link = arguments.rig.robot_link});
  arm.start();
  if (!arguments.write_rig.empty())
    write_text(arguments.write_rig, arm.rig_text(), "--write-rig");
  fmt::print("{}\n", ready_line(arm, arguments));
  return wait_for_signal(signals);
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app{
      "mock rig: robot controller and six dials on Modbus TCP and pseudo-terminals, or an arm "
      "under six draw wires (--robot serial)\nPrints one "
      "line of JSON with its ports when it is ready, and serves until SIGINT or SIGTERM.",
      "sixdial-mock-rig"};
  app.set_version_flag("--version", SIXDIAL_VERSION);
  Arguments arguments;
  arguments.rig.world.rig = geometry::default_rig();
  add_options(app, arguments);
  bool print_manual = false;
  app.add_flag("--print-manual", print_manual, "Print the man page and end");
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    const int code = app.exit(error);
    std::cout.flush();
    return code == 0 && !std::cout ? 1 : code;
  }
  if (print_manual) {
    fmt::print("{}", cli::manual_page(app, 1, false));
    return printed();
  }
  try {
    // Blocked before any thread starts, so that only sigwait sees them.
    sigset_t signals;
    sigemptyset(&signals);
    sigaddset(&signals, SIGINT);
    sigaddset(&signals, SIGTERM);
    pthread_sigmask(SIG_BLOCK, &signals, nullptr);
    if (arguments.controller != kRegisters) {
      arguments.rig.robot_controller = arguments.controller;
    }
    if (arguments.robot == kArm) return run_arm(arguments, signals);
    if (!arguments.fill.empty()) {
      fill_sockets(arguments.fill, arguments.rig.world.seed);
      return 0;
    }
    make_world(arguments);
    if (!arguments.bundle.empty()) {
      write_session(arguments);
      return 0;
    }
    mock_devices::MockRig rig(arguments.rig);
    rig.start();
    if (!arguments.write_rig.empty()) {
      session::write_file(
          arguments.write_rig,
          session::write_rig(as_written_down(arguments.file, rig.connected_rig("modbus-tcp"))));
    }
    fmt::print("{}\n", ready_line(rig, arguments));
    return wait_for_signal(signals);
  } catch (const std::exception& error) {
    fmt::print(stderr, "sixdial-mock-rig: {}\n", error.what());
    return 1;
  }
}
