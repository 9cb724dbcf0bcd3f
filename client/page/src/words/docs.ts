// The texts of the page /docs. The descriptions of the interface come from the server, the documents from the repository.
export const words = {
  title: 'HTTP interface', loading: 'Asking the server …', absent: 'The server does not answer. Reload the page to try again.', token: 'This server needs a token', use: 'Use it',
  contents: 'Contents', home: 'Back to the page', search: 'Search', hint: 'Search ( / )', parameters: 'Parameters', raw: 'For programs:', headers: 'Headers',
  allParameters: (count: number) => `and ${count} parameters of fractures`, body: 'Body:',
  kinds: { tutorial: 'First steps', 'how-to': 'How to', reference: 'Reference', explanation: 'Explanation' },
  pictures: 'its pictures are in the repository',
  found: (count: number, shown: number) => (count === 0 ? 'Nothing found. All words must occur.' : count === 1 ? '1 result' : `${count} results${shown < count ? `, the best ${shown}` : ''}`),
};
