#include "view/gl.h"

namespace feder::view {
namespace {

GLuint compile(const Gl& gl, const char* name, GLenum kind, std::string_view text) {
  const GLuint shader = gl.CreateShader(kind);
  const char* source = text.data();
  const auto size = static_cast<GLint>(text.size());
  gl.ShaderSource(shader, 1, &source, &size);
  gl.CompileShader(shader);
  GLint good = 0;
  gl.GetShaderiv(shader, GL_COMPILE_STATUS, &good);
  if (good) return shader;
  char log[2048] = "";
  gl.GetShaderInfoLog(shader, sizeof log, nullptr, log);
  gl.DeleteShader(shader);
  throw GlError(std::string("shader '") + name + "' does not compile: " + log);
}

}  // namespace

Gl::Gl(const GlLoader& load) {
  std::string missing;
#define FEDER_GL_LOAD(type, name)                               \
  name = reinterpret_cast<PFNGL##type##PROC>(load("gl" #name)); \
  if (!name) missing += missing.empty() ? "gl" #name : ", gl" #name;
  FEDER_GL_FUNCTIONS(FEDER_GL_LOAD)
#undef FEDER_GL_LOAD
  if (!missing.empty()) throw GlError("OpenGL 3.3 is needed; this driver lacks " + missing);
  GLint major = 0, minor = 0;
  GetIntegerv(GL_MAJOR_VERSION, &major), GetIntegerv(GL_MINOR_VERSION, &minor);
  if (10 * major + minor < 33)
    throw GlError("OpenGL 3.3 is needed; this driver has " + std::to_string(major) + "." + std::to_string(minor));
}

void Gl::check(const char* where) const {
  const GLenum error = GetError();
  if (error == GL_NO_ERROR) return;
  const char* name = error == GL_INVALID_ENUM        ? "invalid enum"
                     : error == GL_INVALID_VALUE     ? "invalid value"
                     : error == GL_INVALID_OPERATION ? "invalid operation"
                     : error == GL_OUT_OF_MEMORY     ? "out of memory"
                                                     : "error";
  throw GlError(std::string("OpenGL: ") + name + " (" + std::to_string(error) + ") while drawing " + where);
}

Program::Program(const Gl& gl, const char* name, std::string_view vertex, std::string_view fragment) : gl_(gl) {
  const GLuint v = compile(gl, name, GL_VERTEX_SHADER, vertex);
  GLuint f = 0;
  try {
    f = compile(gl, name, GL_FRAGMENT_SHADER, fragment);
  } catch (...) {
    gl.DeleteShader(v);
    throw;
  }
  id_ = gl.CreateProgram();
  gl.AttachShader(id_, v), gl.AttachShader(id_, f);
  gl.LinkProgram(id_);
  gl.DeleteShader(v), gl.DeleteShader(f);
  GLint good = 0;
  gl.GetProgramiv(id_, GL_LINK_STATUS, &good);
  if (good) return;
  char log[2048] = "";
  gl.GetProgramInfoLog(id_, sizeof log, nullptr, log);
  gl.DeleteProgram(id_);
  throw GlError(std::string("shader '") + name + "' does not link: " + log);
}

Program::~Program() { gl_.DeleteProgram(id_); }

void attach_renderbuffer(const Gl& gl, const GlObject& buffer, GLenum format, GLenum point, int width, int height,
                         int samples) {
  gl.BindRenderbuffer(GL_RENDERBUFFER, buffer.id());
  gl.RenderbufferStorageMultisample(GL_RENDERBUFFER, samples, format, width, height);
  gl.FramebufferRenderbuffer(GL_FRAMEBUFFER, point, GL_RENDERBUFFER, buffer.id());
}

void VertexArray::attributes(std::initializer_list<Attribute> list, std::size_t stride, std::size_t offset,
                             GLuint divisor) const {
  for (const Attribute& a : list) {
    gl_.EnableVertexAttribArray(a.index);
    gl_.VertexAttribPointer(a.index, a.count == kColor ? 4 : a.count, a.count == kColor ? GL_UNSIGNED_BYTE : GL_FLOAT,
                            a.count == kColor ? GL_TRUE : GL_FALSE, static_cast<GLsizei>(stride),
                            reinterpret_cast<const void*>(offset + a.offset));
    gl_.VertexAttribDivisor(a.index, divisor);
  }
}

}  // namespace feder::view
