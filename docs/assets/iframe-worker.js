// Search without a server: browsers start no Worker for a page from a file. Here an iframe runs the script in its place.
// The name has "iframe-worker" in it so that the theme's offline plugin does not load another one from the network.
"use strict"

class FrameWorker extends EventTarget {
  constructor(url) {
    super()
    const frame = document.createElement("iframe")
    frame.hidden = true
    document.body.appendChild(frame)
    this.frame = frame
    this.hear = event => {
      if (event.source !== frame.contentWindow) return
      const message = new MessageEvent("message", { data: event.data })
      this.dispatchEvent(message)
      if (this.onmessage) this.onmessage(message)
    }
    window.addEventListener("message", this.hear)
    const inside = frame.contentWindow.document
    inside.open()
    inside.write(`<html><body><script>
      postMessage = data => parent.postMessage(data, "*")
      importScripts = (...urls) => urls.reduce((before, url) => before.then(() => new Promise(done => {
        const script = document.createElement("script")
        script.src = url
        script.onload = done
        document.body.appendChild(script)
      })), Promise.resolve())
    <\/script><script src="${url}"><\/script></body></html>`)
    inside.close()
    this.loaded = new Promise(resolve => { frame.contentWindow.onload = resolve })  // opening the document took earlier listeners away
  }

  postMessage(data) {
    this.loaded.then(() => {
      this.frame.contentWindow.dispatchEvent(new MessageEvent("message", { data: structuredClone(data) }))
    })
  }

  terminate() {
    window.removeEventListener("message", this.hear)
    this.frame.remove()
  }
}

if (location.protocol === "file:") window.Worker = FrameWorker
