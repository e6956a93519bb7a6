#include <vector>

#include "db/program_store.hpp"
#include "db/store.hpp"
#include "db/time.hpp"
#include "server/api/routes/routes.hpp"
#include "server/api/shapes.hpp"
#include "server/fleet/fleet.hpp"
#include "server/library/programs.hpp"

namespace headstock::api {

namespace {

using boost::asio::awaitable;
using access::Action;

/// Streams the body into the store: a worker writes and hashes a piece while nothing but that piece is in memory.
awaitable<db::BlobRow> receive(Services& s, Body& body) {
  auto upload = co_await s.workers.run([&s] { return std::make_unique<library::Upload>(s.blobs); });
  std::vector<char> piece(512 * 1024);
  for (bool more = true; more;) {
    std::size_t filled = 0;
    while (filled < piece.size()) {
      const auto got = co_await body.read(piece.data() + filled, piece.size() - filled);
      if (got == 0) {
        more = false;
        break;
      }
      filled += got;
    }
    if (filled > 0) co_await s.workers.run([&] { upload->append({piece.data(), filled}); });
  }
  co_return co_await s.workers.run([&] { return upload->finish(); });
}

json added_json(const library::Added& added) {
  json duplicate = nullptr;
  if (added.duplicate_of)
    duplicate = {{"program", added.duplicate_of->program}, {"revision", added.duplicate_of->number}};
  const auto& blob = added.revision.blob;
  return {{"program", to_json(added.program)},
          {"revision", to_json(added.revision)},
          {"created", added.created},
          {"duplicate_of", duplicate},
          {"findings_encoding",
           {{"encoding", blob.encoding},
            {"line_ends", blob.line_ends},
            {"nul_bytes", blob.nul_bytes},
            {"longest_line", blob.longest_line},
            {"has_percent", blob.has_percent}}}};
}

std::vector<Route> folder_routes(Services& s) {
  std::vector<Route> routes;
  routes.push_back({.method = Method::get, .pattern = "/folders", .role = Role::viewer, .summary = "All folders",
                    .response = "Folders", .handler = [&s](Call&) -> awaitable<Reply> {
                      const auto folders = co_await s.store.run([](db::Database& db) { return db::folders(db); });
                      json items = json::array();
                      for (const auto& folder : folders) items.push_back({{"path", folder}});
                      co_return json_reply({{"items", std::move(items)}, {"next", nullptr}});
                    }});
  routes.push_back({.method = Method::post, .pattern = "/folders", .role = needs(Action::arrange_programs),
                    .summary = "Make a folder and those above it", .takes = Takes::json, .request = "Folder",
                    .response = "Folder", .status = 201, .errors = {"bad_folder"},
                    .handler = [&s](Call& call) -> awaitable<Reply> {
                      const auto actor = actor_of(call);
                      const auto path = library::clean_folder(call.body_text("path"));
                      co_await s.store.run(
                          [&](db::Database& db) { library::create_folder(db, actor, path, db::now_ms()); });
                      announce_program(s, "folder", 0);
                      co_return json_reply({{"path", path}}, 201);
                    }});
  routes.push_back({.method = Method::del, .pattern = "/folders", .role = needs(Action::arrange_programs),
                    .summary = "Remove an empty folder", .status = 204,
                    .query = {{"path", "string", "the folder"}}, .errors = {"not_empty"},
                    .handler = [&s](Call& call) -> awaitable<Reply> {
                      const auto actor = actor_of(call);
                      const auto path = library::clean_folder(call.text("path"));
                      co_await s.store.run(
                          [&](db::Database& db) { library::remove_folder(db, actor, path, db::now_ms()); });
                      announce_program(s, "folder", 0);
                      co_return empty_reply();
                    }});
  return routes;
}

}  // namespace

std::vector<Route> program_routes(Services& s) {
  auto routes = folder_routes(s);
  routes.push_back({.method = Method::get, .pattern = "/programs", .role = Role::viewer,
                    .summary = "Programs with their newest and released revision", .response = "Programs",
                    .query = with({{"folder", "string", "exactly this folder"}, {"q", "string", "part of the name"}},
                                  paging),
                    .handler = [&s](Call& call) -> awaitable<Reply> {
                      db::ProgramFilter filter;
                      if (call.request.query.contains("folder"))
                        filter.folder = library::clean_folder(call.text("folder"));
                      filter.text = call.text("q");
                      const auto page = page_of(call);
                      const auto list = co_await s.store.run(
                          [&](db::Database& db) { return db::programs(db, filter, page); });
                      co_return json_reply(list_json(list));
                    }});
  routes.push_back(
      {.method = Method::post, .pattern = "/programs", .role = needs(Action::upload_program),
       .summary = "Store a program: new, or a new revision of the one with that name", .takes = Takes::bytes,
       .response = "Uploaded",
       .query = {{"folder", "string", "`/` unless told"},
                 {"name", "string", "as the file is called"},
                 {"note", "string", "why"}},
       .errors = {"upload_incomplete", "too_large", "bad_name", "bad_folder", "empty_program", "disk_full"},
       .handler = [&s](Call& call) -> awaitable<Reply> {
         library::Place place;
         place.folder = library::clean_folder(call.text("folder", "/"));
         place.name = call.text("name");
         library::demand_good_name(place.name);   // before the bytes come
         const auto actor = actor_of(call);
         const auto note = call.text("note");
         const auto blob = co_await receive(s, *call.upload);
         const auto added = co_await s.store.run([&](db::Database& db) {
           return library::add_revision(db, actor, place, blob, note, "upload", db::now_ms());
         });
         if (added.created) announce_program(s, "revision", added.program.id);
         co_return json_reply(added_json(added));
       }});
  routes.push_back({.method = Method::get, .pattern = "/programs/{id}", .role = Role::viewer,
                    .summary = "One program", .response = "Program", .handler = [&s](Call& call) -> awaitable<Reply> {
                      const auto id = call.id("id");
                      const auto row = co_await s.store.run(
                          [id](db::Database& db) { return library::require_program(db, id); });
                      co_return json_reply(to_json(row));
                    }});
  routes.push_back({.method = Method::patch, .pattern = "/programs/{id}", .role = needs(Action::arrange_programs),
                    .summary = "Move or rename", .takes = Takes::json, .request = "ProgramChange",
                    .response = "Program", .errors = {"name_taken", "bad_name", "bad_folder"},
                    .handler = [&s](Call& call) -> awaitable<Reply> {
                      const auto actor = actor_of(call);
                      const auto id = call.id("id");
                      const auto folder = call.body_text("folder", ""), name = call.body_text("name", "");
                      const auto row = co_await s.store.run([&](db::Database& db) {
                        const auto now = library::require_program(db, id);
                        library::Place to;
                        to.folder = folder.empty() ? now.folder : folder;
                        to.name = name.empty() ? now.name : name;
                        return library::move_program(db, actor, id, to, db::now_ms());
                      });
                      co_await s.fleet.refresh();
                      announce_program(s, "moved", id);
                      co_return json_reply(to_json(row));
                    }});
  routes.push_back({.method = Method::del, .pattern = "/programs/{id}", .role = needs(Action::arrange_programs),
                    .summary = "Take a program out of the library; what happened with it stays known", .status = 204,
                    .errors = {"released"}, .handler = [&s](Call& call) -> awaitable<Reply> {
                      const auto actor = actor_of(call);
                      const auto id = call.id("id");
                      co_await s.store.run(
                          [&](db::Database& db) { library::remove_program(db, actor, id, db::now_ms()); });
                      co_await s.fleet.refresh();
                      announce_program(s, "removed", id);
                      co_return empty_reply();
                    }});
  routes.push_back({.method = Method::get, .pattern = "/programs/{id}/revisions", .role = Role::viewer,
                    .summary = "Every revision, newest first", .response = "Revisions",
                    .handler = [&s](Call& call) -> awaitable<Reply> {
                      const auto id = call.id("id");
                      const auto rows = co_await s.store.run([id](db::Database& db) {
                        library::require_program(db, id);
                        return db::revisions(db, id);
                      });
                      co_return json_reply(list_json(rows));
                    }});
  return routes;
}

}  // namespace headstock::api
