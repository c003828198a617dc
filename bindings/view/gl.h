// The OpenGL functions the renderer uses, found by the host's loader, and thin owners of what lives in the driver. No
// global state: two renderers in two contexts do not meet, and a test can hand in functions of its own.
#pragma once
#include <GL/glcorearb.h>

#include <initializer_list>
#include <string>
#include <string_view>
#include <vector>

#include "view/renderer.h"

namespace feder::view {

// f(type suffix in capitals, name without gl)
// clang-format off
#define FEDER_GL_FUNCTIONS(f)                                                                                          \
  f(GETSTRING, GetString) f(GETINTEGERV, GetIntegerv) f(GETERROR, GetError) f(VIEWPORT, Viewport)                      \
  f(CLEAR, Clear) f(CLEARBUFFERFV, ClearBufferfv) f(ENABLE, Enable) f(DISABLE, Disable) f(DEPTHFUNC, DepthFunc)              \
  f(DEPTHMASK, DepthMask) f(BLENDFUNCSEPARATE, BlendFuncSeparate)                                \
  f(POLYGONOFFSET, PolygonOffset) f(GENBUFFERS, GenBuffers) f(DELETEBUFFERS, DeleteBuffers)                            \
  f(BINDBUFFER, BindBuffer) f(BUFFERDATA, BufferData) f(GENVERTEXARRAYS, GenVertexArrays)                              \
  f(DELETEVERTEXARRAYS, DeleteVertexArrays) f(BINDVERTEXARRAY, BindVertexArray)                                        \
  f(ENABLEVERTEXATTRIBARRAY, EnableVertexAttribArray) f(VERTEXATTRIBPOINTER, VertexAttribPointer)                      \
  f(DISABLEVERTEXATTRIBARRAY, DisableVertexAttribArray) f(VERTEXATTRIBDIVISOR, VertexAttribDivisor) f(VERTEXATTRIB4F, VertexAttrib4f) f(CREATESHADER, CreateShader)          \
  f(SHADERSOURCE, ShaderSource) f(COMPILESHADER, CompileShader) f(GETSHADERIV, GetShaderiv)                            \
  f(GETSHADERINFOLOG, GetShaderInfoLog) f(DELETESHADER, DeleteShader) f(CREATEPROGRAM, CreateProgram)                  \
  f(ATTACHSHADER, AttachShader) f(LINKPROGRAM, LinkProgram) f(GETPROGRAMIV, GetProgramiv)                              \
  f(GETPROGRAMINFOLOG, GetProgramInfoLog) f(DELETEPROGRAM, DeleteProgram) f(USEPROGRAM, UseProgram)                    \
  f(GETUNIFORMLOCATION, GetUniformLocation) f(UNIFORM1I, Uniform1i) f(UNIFORM1F, Uniform1f)                            \
  f(UNIFORM2F, Uniform2f) f(UNIFORM3F, Uniform3f) f(UNIFORM4F, Uniform4f)        \
  f(GENTEXTURES, GenTextures) f(DELETETEXTURES, DeleteTextures) f(BINDTEXTURE, BindTexture)                            \
  f(ACTIVETEXTURE, ActiveTexture) f(TEXIMAGE2D, TexImage2D) f(TEXPARAMETERI, TexParameteri)                            \
  f(PIXELSTOREI, PixelStorei) f(GENFRAMEBUFFERS, GenFramebuffers)                    \
  f(DELETEFRAMEBUFFERS, DeleteFramebuffers) f(BINDFRAMEBUFFER, BindFramebuffer)                                        \
  f(FRAMEBUFFERTEXTURE2D, FramebufferTexture2D) f(FRAMEBUFFERRENDERBUFFER, FramebufferRenderbuffer)                    \
  f(CHECKFRAMEBUFFERSTATUS, CheckFramebufferStatus) f(BLITFRAMEBUFFER, BlitFramebuffer)                                \
  f(DRAWBUFFERS, DrawBuffers) f(READBUFFER, ReadBuffer) f(GENRENDERBUFFERS, GenRenderbuffers)                          \
  f(DELETERENDERBUFFERS, DeleteRenderbuffers) f(BINDRENDERBUFFER, BindRenderbuffer)                                    \
  f(RENDERBUFFERSTORAGEMULTISAMPLE, RenderbufferStorageMultisample)                                                    \
  f(DRAWELEMENTSINSTANCED, DrawElementsInstanced) f(DRAWARRAYSINSTANCED, DrawArraysInstanced)                          \
  f(READPIXELS, ReadPixels) f(BINDBUFFERBASE, BindBufferBase)                                        \
  f(GETUNIFORMBLOCKINDEX, GetUniformBlockIndex) f(UNIFORMBLOCKBINDING, UniformBlockBinding)
// clang-format on

struct Gl {
  explicit Gl(const GlLoader& load);  // GlError naming what the driver lacks
#define FEDER_GL_FIELD(type, name) PFNGL##type##PROC name = nullptr;
  FEDER_GL_FUNCTIONS(FEDER_GL_FIELD)
#undef FEDER_GL_FIELD
  void check(const char* where) const;  // GlError when glGetError says so
};

// A linked program; uniforms by name.
class Program {
 public:
  Program(const Gl& gl, const char* name, std::string_view vertex, std::string_view fragment);
  ~Program();
  Program(const Program&) = delete;
  Program& operator=(const Program&) = delete;
  void use() const { gl_.UseProgram(id_); }
  GLint uniform(const char* name) const { return gl_.GetUniformLocation(id_, name); }
  void bind_block(const char* name, GLuint at) const {
    const GLuint index = gl_.GetUniformBlockIndex(id_, name);
    if (index != GL_INVALID_INDEX) gl_.UniformBlockBinding(id_, index, at);
  }

 private:
  const Gl& gl_;
  GLuint id_ = 0;
};

// What the driver knows by a number: a buffer, a vertex array, a texture, a framebuffer or a renderbuffer.
class GlObject {
 public:
  using Make = PFNGLGENBUFFERSPROC;
  using Delete = PFNGLDELETEBUFFERSPROC;
  GlObject(Make make, Delete destroy) : delete_(destroy) { make(1, &id_); }
  ~GlObject() { delete_(1, &id_); }
  GlObject(const GlObject&) = delete;
  GlObject& operator=(const GlObject&) = delete;
  GLuint id() const { return id_; }

 private:
  Delete delete_;
  GLuint id_ = 0;
};

// Storage for a picture, at a point of the bound framebuffer.
void attach_renderbuffer(const Gl& gl, const GlObject& buffer, GLenum format, GLenum point, int width, int height,
                         int samples);

// A buffer whose content is replaced whole.
class Buffer : public GlObject {
 public:
  explicit Buffer(const Gl& gl) : GlObject(gl.GenBuffers, gl.DeleteBuffers), gl_(gl) {}
  void bind(GLenum what = GL_ARRAY_BUFFER) const { gl_.BindBuffer(what, id()); }
  void bind_block(GLuint at) const { gl_.BindBufferBase(GL_UNIFORM_BUFFER, at, id()); }
  void fill(const void* data, std::size_t bytes, GLenum usage, GLenum what = GL_ARRAY_BUFFER) const {
    bind(what);
    gl_.BufferData(what, static_cast<GLsizeiptr>(bytes), data, usage);
  }
  template <class T>
  void fill(const std::vector<T>& list, GLenum usage, GLenum what = GL_ARRAY_BUFFER) const {
    if (list.empty())
      bind(what);
    else
      fill(list.data(), list.size() * sizeof(T), usage, what);
  }

 private:
  const Gl& gl_;
};

struct Attribute {
  GLuint index;
  int count;           // of floats; kColor: four bytes as 0..1
  std::size_t offset;  // of the field
};
inline constexpr int kColor = 0;

class VertexArray : public GlObject {
 public:
  explicit VertexArray(const Gl& gl) : GlObject(gl.GenVertexArrays, gl.DeleteVertexArrays), gl_(gl) {}
  void bind() const { gl_.BindVertexArray(id()); }
  // Fields of the T in the bound buffer from number `first` on; divisor 1: one per instance.
  template <class T>
  void attributes(std::initializer_list<Attribute> list, std::size_t first = 0, GLuint divisor = 0) const {
    attributes(list, sizeof(T), first * sizeof(T), divisor);
  }

 private:
  void attributes(std::initializer_list<Attribute> list, std::size_t stride, std::size_t offset, GLuint divisor) const;

  const Gl& gl_;
};

}  // namespace feder::view
