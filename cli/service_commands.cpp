// sixdial hello, protocol, completion, manual, shutdown.
#include <fmt/format.h>

#include "cli/cli.h"
#include "cli/manual.h"
#include "service/methods/method.h"

namespace sixdial::cli {

void add_service_commands(CLI::App& app, Cli& cli) {
  app.add_subcommand("hello", summary_of("hello"))->callback([&cli] {
    cli.action = [&cli] {
      const Json answer = cli.call("hello");
      cli.console.print(
          "hello", answer,
          fmt::format(
              "{} {}, protocol {}, up since {}; you are {}\n",
              answer["service"].get<std::string>(), answer["version"].get<std::string>(),
              answer["protocol"].get<int>(), answer["epoch"].get<std::string>(),
              answer["operator"].get<std::string>()));
      return service::ExitCode::kOk;
    };
  });
  CLI::App* protocol =
      app.add_subcommand("protocol", "The socket protocol, from the method table.");
  protocol->add_flag("--markdown")
      ->description("as doc/protocol.md (the default without --json)");
  protocol->callback([&cli] {
    cli.action = [&cli] {
      Json methods = Json::array();
      for (const service::RpcMethod* method : service::all_methods()) {
        methods.push_back(
            {{"name", method->name},
             {"summary", method->summary},
             {"params", service::params_schema(*method)},
             {"result", method->result},
             {"example", Json::parse(method->example)}});
      }
      cli.console.print(
          "protocol", {{"methods", std::move(methods)}}, service::protocol_markdown());
      return service::ExitCode::kOk;
    };
  });
  app.add_subcommand("completion", "Completion for bash: source <(sixdial completion).")
      ->callback([&app, &cli] {
        cli.action = [&app, &cli] {
          const std::string text = bash_completion(app);
          cli.console.print("completion", {{"bash", text}}, text);
          return service::ExitCode::kOk;
        };
      });
  app.add_subcommand("manual", "The man page of sixdial, from the table of its commands.")
      ->callback([&app, &cli] {
        cli.action = [&app, &cli] {
          const std::string text = manual_page(app, 1);
          cli.console.print("manual", {{"roff", text}}, text);
          return service::ExitCode::kOk;
        };
      });
  app.add_subcommand("shutdown", summary_of("shutdown"))->callback([&cli] {
    cli.action = [&cli] {
      cli.console.print("shutdown", cli.call("shutdown"), "");
      cli.console.note("the service is going down");
      return service::ExitCode::kOk;
    };
  });
}

}  // namespace sixdial::cli
